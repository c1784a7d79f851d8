"""`python -m experiments` lists everything that there is to run, and is quick about it."""

import subprocess
import sys
from pathlib import Path

import pytest

from experiments.__main__ import QUESTIONS, TOUR, first_sentence

ROOT = Path(__file__).parents[2]


def listed():
    return subprocess.run([sys.executable, "-m", "experiments"], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def test_every_command_and_every_program_of_the_tour_is_listed_once():
    commands = sorted(path.stem for path in (ROOT / "experiments").glob("[!_]*.py"))
    assert sorted(name for names in QUESTIONS.values() for name in names) == commands
    assert sorted(TOUR) == sorted(path.stem for path in (ROOT / "experiments/tour").glob("[!_]*.py"))


def test_the_list_tells_each_name_with_its_first_sentence_and_how_to_ask_for_help():
    lines = [line.strip() for line in listed().splitlines()]
    for name in (*TOUR, *(name for names in QUESTIONS.values() for name in names)):
        (line,) = [line for line in lines if line.split(maxsplit=1)[:1] == [name]]
        assert line.split(maxsplit=1)[1].endswith((".", "?"))
    assert any("--help" in line for line in lines)


def test_the_list_imports_nothing_that_takes_time():
    told = "import sys; from experiments.__main__ import main; main(); print(*sorted(sys.modules), file=sys.stderr)"
    run = subprocess.run([sys.executable, "-c", told], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not {"numpy", "filter", "sim", "experiments.moving_team", "rich", "tyro"} & set(run.stderr.split())


@pytest.mark.parametrize(
    ("said", "first"),
    [
        ('"""Is it so? Yes."""', "Is it so?"),
        ('"""One\nsentence of 1.5 m.\n\nAnother."""', "One sentence of 1.5 m."),
        ("x = 1", ""),
    ],
)
def test_the_first_sentence_is_that_of_the_docstring(tmp_path, said, first):
    (tmp_path / "module.py").write_text(said)
    assert first_sentence(tmp_path / "module.py") == first
