"""The README is run and held against the code, so that it keeps telling the truth."""

import re
from pathlib import Path

import pytest

import filter as filter_package

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()


def test_the_example_runs_and_prints_regions_that_hold_together(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 40
    exec(compile(example, "README.md", "exec"), {})
    first, second, proof = capsys.readouterr().out.splitlines()
    assert re.match(r"0 \[.*\] 0\.\d+ m2", first)
    assert re.match(r"1 \[.*\] 0\.\d+ m2", second)
    assert "bearing of robot" in proof or "range of robot" in proof


@pytest.mark.parametrize("path", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda path: path.name)
def test_every_file_that_a_text_links_is_there(path):
    links = [link for link in re.findall(r"\]\(([^)#\s]+)\)", path.read_text()) if not link.startswith("http")]
    assert [link for link in links if not (path.parent / link).exists()] == []


def test_the_readme_links_its_documents():
    assert len(set(re.findall(r"\]\((docs/\w[\w-]*\.md)", README))) >= 5


def test_the_reading_order_is_that_of_the_filter():
    """`test_architecture` holds the filter's own order against its imports."""
    listed = README[README.index("`filter/` has nine rooms") :]
    order = [name for line in re.findall(r"^\d+\. (.*?):", listed, re.MULTILINE) for name in re.findall(r"`(\w+/?)`", line)]
    assert order == re.split(r",\s+", re.search(r"slash: (.*?)\.$", filter_package.__doc__, re.DOTALL | re.MULTILINE).group(1))


@pytest.mark.parametrize("option", sorted(set(re.findall(r"experiments\.moving_team.*?--(\w+)", README)) - {"help"}))
def test_the_options_that_the_readme_shows_exist(option):
    assert f"\n    {option}: " in (ROOT / "experiments/moving_team.py").read_text()
