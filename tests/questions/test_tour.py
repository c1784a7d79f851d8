"""The tour: every program runs, keeps the truth inside, would say so if it did not, and needs nothing but the door."""

import ast
import importlib
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from experiments.__main__ import TOUR
from filter import Polygon, Regions

ROOT = Path(__file__).parents[2]
LONGEST = 55  # lines
KNOWN = {"sys", "pathlib", "tempfile", "time", "numpy", "filter", "experiments.logs"}

every_program = pytest.mark.parametrize("name", TOUR)


@every_program
def test_a_program_runs_and_tells_that_the_truth_was_inside(name, monkeypatch, capsys):
    monkeypatch.delitem(sys.modules, f"experiments.tour.{name}", raising=False)  # as if it were the first to be run
    with pytest.raises(SystemExit) as ended:
        runpy.run_module(f"experiments.tour.{name}", run_name="__main__")
    assert ended.value.code == 0
    told = capsys.readouterr().out.splitlines()
    assert 4 <= len(told) <= 30
    assert told[-1].endswith("all the time.")


@every_program
def test_another_seed_is_another_run_as_good(name, capsys):
    program = importlib.import_module(f"experiments.tour.{name}")
    told = []
    for seed in (1, 2, 1):
        assert program.main(seed) == 0
        told.append(capsys.readouterr().out)
    assert told[0] != told[1]
    assert name == "large_team" or told[0] == told[2]  # that one tells times


@every_program
def test_a_truth_outside_is_an_exit_code_of_1(name, monkeypatch, capsys):
    monkeypatch.setattr(Polygon, "contains", lambda self, points: np.zeros(np.shape(points)[:-1], dtype=bool))
    monkeypatch.setattr(Regions, "contains", lambda self, places: np.zeros(len(places), dtype=bool))
    assert importlib.import_module(f"experiments.tour.{name}").main() == 1
    assert capsys.readouterr().out.splitlines()[-1].endswith("outside!")


@every_program
def test_a_program_is_short_and_goes_through_the_door(name):
    text = (ROOT / f"experiments/tour/{name}.py").read_text()
    assert len(text.splitlines()) <= LONGEST
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert {node.module if isinstance(node, ast.ImportFrom) else node.names[0].name for node in nodes} <= KNOWN
