"""One drive told twice, in metres and radians from east and in millimetres and degrees from north, is one log."""

import json
import math

import numpy as np
import pytest
from helpers.own_data.settings_files import OF_TABLES
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from experiments.own_data import convert, read_settings
from experiments.recorded import opened

MOTION = "distance_bound = 0.02, turn_bound = 0.03, direction_bound = 0.04, slip_bound = 0.005, sideways = true, longest = 1.0"
SPEEDS = "speed_bound = 0.02, turn_rate_bound = 0.03, direction_bound = 0.04, slip_rate = 0.005, sideways = true, hold = 0.5"
PLAIN = f"""
[robots.a]
odometry = {{ file = "pose.csv", {MOTION} }}
twist = {{ file = "twist.csv", speed_aside = "speed_aside", {SPEEDS} }}
compass = {{ file = "compass.csv", bound = [-0.03, 0.01] }}
detections = {{ file = "seen.csv", range_bound = 0.1, bearing_bound = [-0.03, 0.01] }}
position = {{ file = "pose.csv", bound = [0.1, 0.2] }}
truth = {{ file = "pose.csv", heading = "heading" }}
[robots.b]
"""
DEGREE = math.pi / 180
MOTION = f"distance_bound = 20, turn_bound = {0.03 / DEGREE}, direction_bound = {0.04 / DEGREE}, slip_bound = 5"
SPEEDS = f"speed_bound = 20, turn_rate_bound = {0.03 / DEGREE}, direction_bound = {0.04 / DEGREE}, slip_rate = 5"
ASIDE = 'sideways = true, speed_aside = "speed_aside"'
NORTH = 'unit = ["degrees", "millimetres"], convention = "ned"'
LOPSIDED = f"[{-0.01 / DEGREE}, {0.03 / DEGREE}]"
NEEDLE = 0.05  # so far east of north the needle points [rad]
OTHER = f"""
[robots.a]
odometry = {{ file = "pose.csv", {MOTION}, longest = 1.0, sideways = true, {NORTH} }}
twist = {{ file = "twist.csv", {SPEEDS}, hold = 0.5, {ASIDE}, {NORTH} }}
compass = {{ file = "compass.csv", bound = {LOPSIDED}, unit = "degrees", convention = "ned", declination = {NEEDLE / DEGREE} }}
detections = {{ file = "seen.csv", range_bound = 100, bearing_bound = {LOPSIDED}, {NORTH} }}
position = {{ file = "pose.csv", bound = [200, 100], unit = "millimetres", convention = "ned" }}
truth = {{ file = "pose.csv", heading = "heading", {NORTH} }}
[robots.b]
"""


def told_plainly(poses, speeds, seen):
    """Return the tables of a drive in metres and radians, x to the east."""
    return {"pose": poses, "compass": poses[:, 2:], "twist": speeds, "seen": seen}


def told_otherwise(poses, speeds, seen):
    """Return those in millimetres and degrees, north first, clockwise, by a needle that points aside."""
    x, y, heading = poses.T
    north = (np.pi / 2 - heading) / DEGREE
    forward, left, turn_rate = speeds.T
    return {
        "pose": np.stack([1000 * y, 1000 * x, north], axis=1),
        "compass": north[:, None] - NEEDLE / DEGREE,
        "twist": np.stack([1000 * forward, -1000 * left, -turn_rate / DEGREE], axis=1),
        "seen": np.stack([1000 * seen[:, 0], -seen[:, 1] / DEGREE], axis=1),
    }


HEADERS = {"pose": "x,y,heading", "compass": "heading", "twist": "speed,speed_aside,turn_rate", "seen": "range,bearing,id"}


def log_of(folder, tables, streams):
    """Write tables and settings; return the records of their log."""
    folder.mkdir(exist_ok=True)
    for name, table in tables.items():
        who = ",b" if name == "seen" else ""
        rows = [",".join(map(repr, (k, *row))) + who for k, row in enumerate(table.tolist())]
        (folder / f"{name}.csv").write_text("\n".join([f"t,{HEADERS[name]}", *rows]) + "\n")
    (folder / "my.toml").write_text(OF_TABLES + streams)
    convert(read_settings(folder / "my.toml"), opened(folder, "", ()), folder / "out.jsonl")
    return [json.loads(line) for line in (folder / "out.jsonl").read_text().splitlines()]


def drawn(*columns):
    return st.lists(st.tuples(*columns), min_size=3, max_size=3).map(np.array)


@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    drawn(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)),
    drawn(st.floats(-5, 5), st.floats(-5, 5), st.floats(-9, 9)),
    drawn(st.floats(0, 9), st.floats(-3, 3)),
)
def test_both_tellings_are_one_log(tmp_path, poses, speeds, seen):
    turns = np.diff(poses[:, 2])
    assume((np.abs(np.abs(turns) - np.pi) > 1e-6).all())  # half a circle has two ways, and rounding takes one
    first = log_of(tmp_path / "plain", told_plainly(poses, speeds, seen), PLAIN)
    second = log_of(tmp_path / "other", told_otherwise(poses, speeds, seen), OTHER)
    assert len(first) == len(second) == 3 + 2 + 5 * 3 + 3
    for one, other in zip(first, second, strict=True):
        assert one.keys() == other.keys()
        for name in one:
            check_the_same(name, one, other)


def check_the_same(name, one, other):
    """Angles are the same on the circle; how a robot went aside says something only if it went at all."""
    if name in ("heading", "turn", "bearing") and one["record"] != "initial":
        assert np.exp(1j * one[name]) == pytest.approx(np.exp(1j * other[name]))
    elif name == "aside":
        size = "distance" if one["record"] == "odometry" else "speed"
        assert one[size] * np.exp(1j * one[name]) == pytest.approx(other[size] * np.exp(1j * other[name]), abs=1e-9)
    elif isinstance(one[name], float | list) and name not in ("robots", "arena"):
        assert one[name] == pytest.approx(other[name], abs=1e-9)
    else:
        assert one[name] == other[name]
