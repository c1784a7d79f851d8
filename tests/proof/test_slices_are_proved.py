"""Runs without compass are proved from the slices that are taken along; what is changed in these is refused."""

import shutil

import numpy as np
import pytest
from helpers.proved.forgeries import Forgeries, check_refused
from helpers.proved.runs import HEADINGS, lines_of, moved, run_of
from helpers.worlds import World
from hypothesis import given
from hypothesis import strategies as st

from experiments import prove
from experiments.logs import Header, InitialSet, LogWriter
from experiments.moving_team import main as moving_team
from experiments.proof import chain
from experiments.proof.cases import slices as exact
from experiments.proof.cases.polygon import Polygon
from experiments.proof.exact import PI, Arc, Fraction
from filter import Frame, Truth
from filter.poses.slices import COUNT, DIRECTIONS

LINES = "certificates.jsonl.gz"
seeds = st.integers(0, 2**32 - 1)


def run_without_compass(path, seed, robots, landmarks, steps=6):
    """Return the folder of a run of robots that see landmarks and one another, and know no heading at first."""
    world = World(np.random.default_rng(seed), robots=robots, landmarks=landmarks, errors="extreme")
    initial = [InitialSet(one.vertices, None) for one in world.initial_sets()]
    with LogWriter(path / "given.jsonl", Header(world.team, 0.0, 10.0), initial) as log:
        for k in range(steps):
            motion, told = world.tour() if k else None, tuple(world.measure(compasses=False))
            log.write(Frame(world.time, motion, told, Truth(world.positions, world.headings)))
    folder = path / "run"
    how = ["--certificates", "--light", "--out", str(folder)]
    assert moving_team(["--replay", str(path / "given.jsonl"), *how]) == 0
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return run_without_compass(tmp_path_factory.mktemp("slices"), 0, 3, 1)


def test_a_run_without_compass_is_proved(run, capsys):
    assert prove.main([str(run)]) == 0
    assert "robots, case by case" in capsys.readouterr().out
    assert with_roots(lines_of(run, HEADINGS))


@pytest.mark.parametrize("seed", [1, 2])
def test_others_are_too(tmp_path, seed):
    assert prove.main([str(run_without_compass(tmp_path, seed, 3 - seed, seed))]) == 0


def with_roots(lines):
    """Return the certificates of cases that begin from slices, of all steps."""
    return [line for record in lines for line in record["lines"] if line.get("roots")]


forged = Forgeries()


@forged("cases that begin from less than the slices", HEADINGS)
def a_root_that_reaches_less_far(lines):
    root = with_roots(lines)[0]["roots"][0]
    root["reach"][5] = moved(root["reach"][5], -1e-6)


@forged("cases that begin from less than the slices", HEADINGS)
def a_root_that_looks_elsewhere(lines):
    root = with_roots(lines)[-1]["roots"][-1]
    root["arc"][1] = moved(root["arc"][1], -1e-9)


@forged("where", HEADINGS)
def a_root_that_is_left_out(lines):
    case = with_roots(lines)[0]
    del case["roots"][0], case["pieces"][0]


@forged("slices, where", HEADINGS)
def roots_that_nobody_proved(lines):
    first = next(line for record in lines for line in record["lines"] if "pieces" in line)
    first["roots"] = with_roots(lines)[0]["roots"]


@forged("can be beyond its slices", HEADINGS)
def a_slice_that_reaches_less_far(lines):
    for each in with_roots(lines)[0]["slices"]:
        each["reach"] = [moved(far, -0.05) for far in each["reach"]]


@forged("can be beyond its slices", HEADINGS)
def a_slice_that_is_left_out(lines):
    del with_roots(lines)[0]["slices"][0]


@forged("can be beyond its slices", HEADINGS)
def a_slice_that_is_narrower(lines):
    last = with_roots(lines)[0]["slices"][-1]
    last["arc"][1] = (float.fromhex(last["arc"][1]) / 2).hex()


@forged("another number of directions", HEADINGS)
def a_slice_with_fewer_directions(lines):
    with_roots(lines)[0]["slices"][0]["reach"].pop()


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(run, tmp_path, capsys, name):
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    check_refused(copy, forged[name], capsys)


def test_that_no_case_is_left_has_to_be_said(tmp_path, capsys, monkeypatch):
    folder = run_of(tmp_path, steps=3)
    monkeypatch.setattr(chain, "check_cases", lambda *_: None)
    assert prove.main([str(folder)]) == 1
    assert "no case is left of a robot's poses at t = 0.0 s" in capsys.readouterr().out


def test_directions_are_those_of_the_filter():
    assert np.array([[float(x), float(y)] for x, y in exact.DIRECTIONS]) == pytest.approx(DIRECTIONS, abs=1e-16)
    assert exact.COUNT == COUNT


@given(seeds)
def test_slices_are_around_poses_only_if_every_heading_is_in_one(seed):
    rng = np.random.default_rng(seed)
    ends = [sorted(Fraction(int(rng.integers(-12, 13)), 4) for _ in range(2)) for _ in range(4)]
    turns = [int(rng.integers(-2, 3)) for _ in ends]
    place, low, high = Polygon.around([(Fraction(0), Fraction(0))]), *ends[0]
    far = [bool(rng.random() < 0.8) for _ in ends]
    slices = [
        exact.Slice(Arc.between(a, b).turned(turn), [exact.STEPS if is_around else -exact.STEPS] * COUNT)
        for (a, b), turn, is_around in zip(ends[1:], turns, far, strict=False)
    ]
    within = [(a, b) for (a, b), is_around in zip(ends[1:], far, strict=False) if is_around]
    inside = [low + (high - low) * Fraction(k, 64) for k in range(65)]
    hair, tau = Fraction(1, 10**6), 2 * PI
    found = exact.are_around(slices, place, Arc.between(low, high))
    if found:
        assert all(any(a - hair <= at + tau * k <= b + hair for a, b in within for k in range(-2, 3)) for at in inside)
    if all(any(a + hair <= at <= b - hair for a, b in within) for at in inside):
        assert found
