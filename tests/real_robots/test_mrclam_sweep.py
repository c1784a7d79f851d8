import json
from concurrent.futures import Future
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.mrclam_folder import Made, write_run

from experiments import mrclam_sweep
from experiments.mrclam_sweep import Options, Outcome, cases, judged, main, summary_of
from experiments.real_robots.data import read_tables, run_of
from experiments.real_robots.faults import FAULTS, faulty
from filter.geometry.angles import wrap


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("data") / "made", Made(robots=3, duration=12.0, apart=4.0))


def outcome(**changed):
    plain = {"fault": "biased", "robot": 2, "others": 0, "others_in_force": 0, "positions": 0, "headings": 3}
    return Outcome(**(plain | {"named": "camera of r1 60 s", "missed": 0, "wrong": ""} | changed))


def test_every_fault_of_every_robot_is_a_case_and_the_good_run_is_one(folder):
    assert cases(Options(folder, "none,swapped", "1,3")) == [("none", 1), ("swapped", 1), ("swapped", 3)]


def test_a_good_run_lets_nobody_escape_and_names_nobody(folder):
    found = judged(Options(folder), "none", 1)
    assert (found.others, found.others_in_force, found.positions, found.headings) == (0, 0, 0, 0)
    assert (found.named, found.missed, found.wrong) == ("", 0, "")


def test_swapped_barcodes_let_nobody_escape_who_is_promised_to_be_inside(folder):
    found = judged(Options(folder), "swapped", 2)
    assert found.others_in_force == 0
    assert found.missed == (not found.named)


def test_the_table_has_a_line_a_run_and_the_code_is_that_of_the_others(folder, tmp_path, monkeypatch, capsys):
    options = ["--data", str(folder), "--faults", "none,biased", "--fault-robots", "1", "--duration", "2", "--workers", "1"]
    assert main([*options, "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["runs"], summary["others_outside_in_force"], summary["sensors_missed"]) == (2, 0, 1)
    assert summary["biased_1_missed"] == 1
    assert "biased" in capsys.readouterr().out


def test_the_figures_are_added_up():
    found = summary_of([outcome(), outcome(fault="swapped", others=4, others_in_force=1, missed=2, wrong="camera of r0 3 s")])
    assert (found["others_outside"], found["others_outside_in_force"], found["guilty_headings_outside"]) == (4, 1, 6)
    assert (found["sensors_missed"], found["sensors_wrongly_named"]) == (2, 1)
    assert found["biased_2_named"] == "camera of r1 60 s"


def test_escapes_of_others_in_force_end_with_one(folder, tmp_path, monkeypatch):
    bad = outcome(fault="none", robot=1, others=1, others_in_force=1)

    @contextmanager
    def pool(_):
        done = Future()
        done.set_result(bad)
        yield SimpleNamespace(submit=lambda *_: done)

    monkeypatch.setattr(mrclam_sweep, "executor", pool)
    options = ["--faults", "none", "--fault-robots", "1", "--out", str(tmp_path)]
    assert main(["--data", str(folder), *options]) == 1


@pytest.mark.parametrize("options", ["--faults lazy", "--fault-robots 7", "--fault-robots 1;2", "--seed -1"])
def test_bad_input_ends_with_two(folder, tmp_path, options, capsys):
    assert main(["--data", str(folder), *options.split(), "--out", str(tmp_path)]) == 2
    assert "expected" in capsys.readouterr().err


def test_barcodes_that_are_exchanged_later_are_right_before(folder):
    tables = read_tables(folder)
    plain, after = run_of(tables), run_of(FAULTS["exchanged"](tables, 2, 6.0))
    early = plain.logs[1].measurements[:, 0] < 6.0
    before, now = plain.logs[1].measurements[:, 1], after.logs[1].measurements[:, 1]
    assert (now[early] == before[early]).all()
    assert {(int(a), int(b)) for a, b in zip(before[~early], now[~early], strict=True) if a != b} == {(2, 3), (3, 2)}


def test_a_camera_can_be_knocked_to_either_side(folder):
    tables = read_tables(folder)
    left, right = (FAULTS[name](tables, 2, 0.0).logs[2].measurements[:, 3] for name in ("biased", "biased_right"))
    assert faulty(tables, "biased_right", 2).name == tables.name
    np.testing.assert_allclose(wrap(left - right), np.radians(40), atol=1e-9)
