"""What robots see of their mates' headings, as the checker takes it: the truth inside, and no wider than the filter's."""

import shutil
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.forgeries import Forgeries, check_refused
from helpers.proved.runs import lines_of, moved
from helpers.proved.streams import written

from experiments import prove
from experiments.follow import main
from experiments.proof.exact import Arc, arc_around
from experiments.proof.given.frame import MATES, Frame, Reading
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken
from experiments.proof.sides import looking, tied
from experiments.prove import HEADINGS
from filter import AngularIntervals, Compass, RelativeHeading, wrap
from filter.sensing.headings import narrowed_headings
from filter.sensing.readings import Readings

WIDE = [0.05, 1.0, 3.0, np.pi]


def drawn(rng):
    """Return how some robots look, what is known of that, and compasses and relative headings, some of them useless."""
    robots = int(rng.integers(2, 6))
    looks, wide = wrap(rng.choice([0.0, np.pi, 2.0], robots) + rng.uniform(-0.1, 0.1, robots)), rng.choice(WIDE, robots)
    known = AngularIntervals(looks + 0.99 * wide * rng.uniform(-1, 1, robots), wide)
    robot = rng.integers(robots, size=8)
    mate = (robot + rng.integers(1, robots, 8)) % robots
    bound = rng.choice([0.0, 0.02, 0.5, 2.5, np.pi], 8)
    off = bound * np.where(rng.random(8) < 0.3, rng.choice([-1.0, 1.0], 8), rng.uniform(-1, 1, 8))
    seen = RelativeHeading(0.0, robot, mate, wrap(looks[mate] - looks[robot] + off), np.minimum(bound + 1e-15, np.pi))
    return looks, known, [Compass(0.0, 0, looks[0] + 0.01, 0.011), seen]


def given(records):
    """Return the same readings as the checker has them."""
    frame, (compass, seen) = Frame(0.0), records
    frame.readings["compass", 0, None] = [Reading(*map(Fraction, (compass.heading.item(), compass.bound.item())))]
    for robot, mate, value, bound in zip(
        *(each.tolist() for each in (seen.robot, seen.target, seen.heading, seen.bound)), strict=True
    ):
        frame.readings.setdefault((MATES, robot, mate), []).append(Reading(Fraction(value), Fraction(bound)))
    return frame


@pytest.mark.parametrize("seed", [*range(40), 778, 942])
def test_it_is_proved_with_the_truth_inside(seed):
    looks, known, records = drawn(np.random.default_rng(seed))
    arcs = [arc_around(*each) for each in zip(known.centre.tolist(), known.bound.tolist(), strict=True)]
    found = looking(given(records), arcs)
    claimed = narrowed_headings(known, Readings.of(0.0, records), AngularIntervals.circles(0))
    for arc, look, *claim in zip(found, looks.tolist(), claimed.centre.tolist(), claimed.bound.tolist(), strict=True):
        assert arc.widened(Fraction(0), Fraction(1, 10**14)).covers(Arc.between(Fraction(look), Fraction(look)))
        assert arc_around(*claim).covers(arc)
    assert tied(given(records), found) == found


def test_a_bearing_counts_though_no_end_of_what_is_left_is_its_own(tmp_path, capsys):
    """What one bearing and a wide relative heading leave is at both ends of these; another bearing takes one away."""
    head = {"record": "header", "format": "corral-log", "version": 2, "robots": 2, "landmarks": [[5, 0], [0, 5]], "start": 0}
    spots = [{"record": "initial", "robot": k, "vertices": [[0, 0], [0.01, 0.01]], "heading": None} for k in (0, 1)]
    at = {"time": 0, "robot": 0}
    lines = [{**head, "arena": [[-9, -9], [9, 9]], "speed_limit": 0, "turn_rate_limit": 0}, *spots]
    lines += [{**at, "record": "bearing", "landmark": 0, "bearing": -0.1, "bound": 1.09}]  # looks from about -1 to 1.2
    lines += [{**at, "record": "bearing", "landmark": 1, "bearing": np.pi / 2 - 1.25, "bound": 0.74}]  # from 0.5 to 2
    lines += [{**at, "record": "compass", "robot": 1, "heading": 0, "bound": 0.05}]
    lines += [{**at, "record": "relative_heading", "robot": 1, "target": 0, "heading": 3.59, "bound": 2.44}]  # from 1.1 to -0.2
    log = written(tmp_path / "given.jsonl", [*lines, {"record": "frame", "time": 0}])
    assert main([str(log), "--certificates", "--out", str(tmp_path / "run")]) == 0
    assert float.fromhex(lines_of(tmp_path / "run", HEADINGS)[-1]["bound"][0]) < 0.06
    assert prove.main([str(tmp_path / "run")]) == 0
    assert "2 headings, from bearings, too" in capsys.readouterr().out


forged = Forgeries()
CHAIN = [("a", "b"), ("b", "c")]  # who sees whom; the last one alone has a compass


def logged(path):
    """Write the log of three robots that stand, two of which know how they look by the next one alone; return its path."""
    ways = dict(zip("abc", (0.5, 3.0, -2.0), strict=True))
    sensors = {"camera": {"angle": 2.5, "angle_bound": 0.01}, "tag": {"angle": -3.0}}
    head = {"record": "header", "format": "corral-log", "version": 2, "robots": list(ways), "landmarks": {"gate": [3, 3]}}
    lines = [{**head, "arena": [[-9, -9], [9, 9]], "speed_limit": 0, "turn_rate_limit": 0, "start": 0.0, "sensors": sensors}]
    lines += [{"record": "initial", "robot": name, "vertices": [[0, 0], [1, 0], [0, 1]], "heading": None} for name in ways]
    for robot, mate in CHAIN:
        seen = {"record": "relative_heading", "time": 0.0, "robot": robot, "target": mate, "bound": [-0.02, 0.01]}
        lines.append({**seen, "heading": ways[mate] - 3.0 - ways[robot] - 2.5, "sensor": "camera", "target_sensor": "tag"})
    lines += [
        {"record": "compass", "time": 0.0, "robot": "c", "heading": -2.0, "bound": 0.05},
        {"record": "frame", "time": 0.0},
    ]
    return written(path / "given.jsonl", lines)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("chain")
    assert main([str(logged(path)), "--certificates", "--light", "--out", str(path / "run")]) == 0
    return path / "run"


def test_headings_that_mates_alone_tell_are_proved(folder, capsys):
    assert prove.main([str(folder)]) == 0
    assert "3 headings, from odometry, compasses and mates" in capsys.readouterr().out
    (record,) = lines_of(folder, HEADINGS)
    assert [float.fromhex(bound) for bound in record["bound"]] == pytest.approx([0.1, 0.075, 0.05], abs=1e-9)


def first_of(log, kind):
    return next(record for record in log if record["record"] == kind)


@forged("the heading of robot 0 is not proved")
def a_mate_that_is_seen_less_well_by_a_hair(log):
    first_of(log, "relative_heading")["bound"][1] += 1e-9


@forged("the heading of robot 0 is not proved")
def a_mate_that_looks_elsewhere_by_a_hair(log):
    first_of(log, "relative_heading")["heading"] += 1e-9


@forged("the heading of robot 0 is not proved")
def another_mate(log):
    first_of(log, "relative_heading")["target"] = "c"


@forged("the heading of robot 0 is not proved")
def another_robot(log):
    first_of(log, "relative_heading").update(robot="c", target="b")


@forged("the heading of robot 0 is not proved")
def the_mate_who_sees(log):
    first_of(log, "relative_heading").update(robot="b", target="a")


@forged("the heading of robot 0 is not proved")
def nobody_who_is_seen(log):
    log.remove(first_of(log, "relative_heading"))


@forged("the heading of robot 0 is not proved")
def a_compass_that_is_worse_two_mates_away(log):
    first_of(log, "compass")["bound"] += 1e-9


@forged("the heading of robot 0 is not proved")
def a_camera_that_may_look_elsewhere(log):
    log[0]["sensors"]["camera"]["angle_bound"] += 1e-9


@forged("the heading of robot 0 is not proved")
def a_tag_that_may_be_turned(log):
    log[0]["sensors"]["tag"]["angle_bound"] = 1e-9


@forged("the heading of robot 0 is not proved")
def a_tag_that_is_turned(log):
    log[0]["sensors"]["tag"]["angle"] += 1e-9


@forged("the heading of robot 0 is not proved")
def no_tag(log):
    del first_of(log, "relative_heading")["target_sensor"]


@forged("a target other than the robot that measures")
def oneself(log):
    first_of(log, "relative_heading")["target"] = "a"


@forged("was expected, not 'gate'")
def a_landmark_that_looks(log):
    first_of(log, "relative_heading")["target"] = "gate"


@forged("of ['bound', 'heading', 'robot', 'target', 'time'] was expected")
def a_landmark_besides(log):
    first_of(log, "relative_heading")["landmark"] = None


@forged("the lower one first")
def a_pair_the_wrong_way_round(log):
    first_of(log, "relative_heading")["bound"].reverse()


@forged("is away")
def a_mate_that_is_away(log):
    log.remove(next(record for record in log if record["record"] == "initial" and record["robot"] == "a"))


@forged("the heading of robot 1 is not proved", HEADINGS)
def a_heading_that_is_narrower(records):
    records[0]["bound"][1] = moved(records[0]["bound"][1], -1e-9)


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(folder, tmp_path, name, capsys):
    check_refused(Path(shutil.copytree(folder, tmp_path / "copy")), forged[name], capsys)


def test_version_1_has_no_such_record(tmp_path):
    head = {"record": "header", "format": "corral-log", "version": 1, "robots": 2, "landmarks": [], "rate": None, "start": 0}
    head |= {"arena": [[-9, -9], [9, 9]], "speed_limit": 0, "turn_rate_limit": 0}
    known = [{"record": "initial", "robot": robot, "vertices": [[0, 0]], "heading": None} for robot in (0, 1)]
    seen = {"record": "relative_heading", "time": 0, "robot": 0, "target": 1, "heading": 1.0, "bound": 0.1}
    written(tmp_path / "log.jsonl", [head, *known, {"record": "frame", "time": 0}])
    assert len(Log(tmp_path).frames) == 1
    written(tmp_path / "log.jsonl", [head, *known, seen, {"record": "frame", "time": 0}])
    with pytest.raises(Broken, match="a record 'relative_heading' that there is not"):
        Log(tmp_path)
