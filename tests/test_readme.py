"""The README is run and held against the code, so that it keeps telling the truth."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def test_the_example_runs_and_prints_regions_that_hold_together(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 40
    exec(compile(example, "README.md", "exec"), {})
    first, second, proof = capsys.readouterr().out.splitlines()
    assert re.match(r"0 \[.*\] 0\.\d+ m2", first)
    assert re.match(r"1 \[.*\] 0\.\d+ m2", second)
    assert "bearing of robot" in proof or "range of robot" in proof


def test_every_file_that_the_readme_links_is_there():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert links
    assert [link for link in links if not link.startswith("http") and not (ROOT / link).exists()] == []


def test_the_reading_order_names_every_module_of_the_filter_once():
    listed = README[README.index("`filter/` reads from top") :]
    order = [name for line in re.findall(r"^\d+\. (.*?):", listed, re.MULTILINE) for name in re.findall(r"`(\w+)`", line)]
    modules = {path.stem for path in (ROOT / "filter").glob("*.py")} - {"__init__"}
    assert sorted(order) == sorted(modules)


def test_the_reading_order_is_that_of_the_imports():
    listed = README[README.index("`filter/` reads from top") :]
    order = [name for line in re.findall(r"^\d+\. (.*?):", listed, re.MULTILINE) for name in re.findall(r"`(\w+)`", line)]
    for place, name in enumerate(order):
        imported = re.findall(r"^from filter\.(\w+) import", (ROOT / f"filter/{name}.py").read_text(), re.MULTILINE)
        assert set(imported) <= set(order[:place]), name


@pytest.mark.parametrize("option", sorted(set(re.findall(r"experiments\.moving_team.*?--(\w+)", README)) - {"help"}))
def test_the_options_that_the_readme_shows_exist(option):
    assert f"\n    {option}: " in (ROOT / "experiments/moving_team.py").read_text()
