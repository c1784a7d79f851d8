"""Detections with poses: where a mate is in a sensor's frame, and which way it looks."""

import math

import pytest
from helpers.own_data.settings_files import OF_TABLES, of_robots

from experiments.convert import main
from experiments.logs import LogReader
from experiments.show.command import BAD_INPUT
from filter import Bearing, Range, RelativeHeading, seen_position

TABLE = "t,id,x,y,yaw\n0.5,b,3.0,-1.0,0.5\n0.5,gate,1,2,0.1\n1.0,b,0.1,0.0,\n"
POSES = 'file = "seen.csv", x = "x", y = "y", position_bound = 0.2'
HEADINGS = 'heading = "yaw", heading_bound = [-0.1, 0.3]'
POLAR = 'file = "seen.csv", range = "x", bearing = "yaw", range_bound = 0.1, bearing_bound = 0.1'


@pytest.fixture
def converted(tmp_path, capsys):
    """Return a function that converts a table of detections; it returns exit code, records as read, and what was told."""

    def converted(stream, table=TABLE):
        (tmp_path / "seen.csv").write_text(table)
        (tmp_path / "my.toml").write_text(of_robots(OF_TABLES, detections=stream))
        code, out = main([str(tmp_path / "my.toml"), str(tmp_path), str(tmp_path / "out.jsonl")]), tmp_path / "out.jsonl"
        return code, list(LogReader(out).records()) if out.exists() else [], capsys.readouterr().err

    return converted


def told(record):
    return type(record), [getattr(record, name).tolist() for name in vars(record) if name != "time"]


def test_poses_become_bearings_ranges_and_headings(converted):
    code, records, said = converted(f"{POSES}, {HEADINGS}")
    assert code == 0
    heading = RelativeHeading(0.5, 0, 1, 0.4, 0.2)
    seen = [*seen_position(0.5, 0, 1, [3, -1], 0.2), heading, *seen_position(0.5, 0, 2, [1, 2], 0.2)]
    seen += seen_position(1.0, 0, 1, [0.1, 0], 0.2)
    assert [type(record) for record in records] == [Bearing, Range, RelativeHeading, Bearing, Range, Bearing, Range]
    for record, expected in zip(records, seen, strict=True):
        if record is not records[2]:
            assert told(record) == told(expected)
    assert (records[2].heading.item(), records[2].bound.item()) == pytest.approx((0.4, 0.2), abs=1e-12)
    assert "1 headings: of landmarks a heading says nothing" in said
    assert "1 headings: nothing in heading" in said


def test_clockwise_degrees_and_millimetres_are_understood(converted):
    table = f"t,id,x,y,yaw\n0.5,b,3000,1000,{math.degrees(-0.5)}\n"
    units = 'unit = ["degrees", "millimetres"], convention = "ned"'
    bounds = f'position_bound = 200, heading = "yaw", heading_bound = [{math.degrees(-0.3)}, {math.degrees(0.1)}]'
    code, (bearing, reach, heading), _ = converted(f'file = "seen.csv", x = "x", y = "y", {bounds}, {units}', table)
    assert code == 0
    assert [told(bearing), told(reach)] == [told(each) for each in seen_position(0.5, 0, 1, [3, -1], 0.2)]
    assert (heading.heading.item(), heading.bound.item()) == pytest.approx((0.4, 0.2), abs=1e-12)


def test_a_heading_goes_with_range_and_bearing_as_well(converted):
    code, records, _ = converted(f"{POLAR}, {HEADINGS}", TABLE.splitlines()[0] + "\n0.5,b,3.0,-1.0,0.5\n")
    assert code == 0
    assert [type(record) for record in records] == [Bearing, Range, RelativeHeading]


@pytest.mark.parametrize(
    ("stream", "why"),
    [
        (POSES.replace(", position_bound = 0.2", ""), 'a bound "position_bound", the largest error'),
        (POSES.replace("0.2", "[-0.1, 0.2]"), "position_bound: a bound from 0 on"),
        (POSES.replace(', y = "y"', ""), "range and bearing or x and y"),
        (f'{POSES}, heading = "yaw"', 'a bound "heading_bound"'),
        (f"{POSES}, heading_bound = 0.1", '"heading_bound"'),
        (f"{POSES}, range_bound = 0.1", '"range_bound"'),
        (f"{POLAR}, position_bound = 0.1", '"position_bound"'),
        (f'{POSES}, heading = "yaw", heading_bound = 5', "an angle of 180 degrees at most"),
        (f'{POSES}, heading = "x", heading_bound = 0.1', None),
    ],
)
def test_bounds_are_asked_for_what_is_read_and_for_nothing_else(converted, stream, why):
    code, _, said = converted(stream)
    assert code == (BAD_INPUT if why else 0)
    assert (why or "") in said


def test_degrees_that_nobody_declared_are_refused(converted):
    code, _, said = converted(f"{POSES}, {HEADINGS}", TABLE.replace("0.5\n", "90\n"))
    assert code == BAD_INPUT
    assert 'seen.csv, line 2: angles in radians; declare unit = "degrees"' in said
