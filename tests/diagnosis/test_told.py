"""What is left of readings without a suspect, and who has said something."""

import pytest

from filter import Bearing, Compass, Position, Range, RelativeHeading, Suspect
from filter.diagnosis.told import in_one_order, said, signature, without, without_all, without_robots, without_ties

# Robots 0, 1, 2 and landmarks 3, 4.
RECORDS = (
    Compass(0.0, [0, 1], [0.1, 0.2], 0.3),
    Bearing(0.0, [0, 0, 1, 2], [1, 3, 3, 0], [0.1, 0.2, 0.3, 0.4], 0.1),
    Range(0.0, [0, 2], [2, 4], [1.0, 2.0], 0.1, 0.0),
    Position.fix(0.0, 2, [0.0, 0.0], 1.0),
    RelativeHeading(0.0, 1, 0, 0.5, 0.1),
)


def told(records):
    """Return kinds, robots and targets of single readings, each once."""
    return {
        (type(record).__name__, robot, target)
        for record in records
        for robot, target in zip(record.robot.tolist(), getattr(record, "target", record.robot * 0 - 1).tolist(), strict=True)
    }


@pytest.mark.parametrize(
    ("suspect", "gone"),
    [
        (Suspect("past", 0), set()),
        (Suspect("compass", 0), {("Compass", 0, -1)}),
        (Suspect("sensor", 0), {("Bearing", 0, 1), ("Bearing", 0, 3), ("Range", 0, 2)}),
        (Suspect("sensor", 2), {("Bearing", 2, 0), ("Range", 2, 4), ("Position", 2, -1)}),
        (Suspect("body", None, 3), {("Bearing", 0, 3), ("Bearing", 1, 3)}),
        (Suspect("body", None, 0), {("Bearing", 2, 0), ("RelativeHeading", 1, 0)}),
        (Suspect("sighting", 1, 3), {("Bearing", 1, 3)}),
        (Suspect("sighting", 1, 0), {("RelativeHeading", 1, 0)}),
    ],
)
def test_a_suspect_has_said_what_is_left_out_and_nothing_else(suspect, gone):
    assert told(RECORDS) - told(without(suspect, RECORDS)) == gone
    assert told(without(suspect, RECORDS)) <= told(RECORDS)


def test_of_exchanged_markers_each_is_read_as_the_other_and_nobody_sees_itself():
    left = without(Suspect("exchange", 1, 2), RECORDS)
    bearing = next(record for record in left if isinstance(record, Bearing))
    assert told([bearing]) == {("Bearing", 0, 2), ("Bearing", 0, 3), ("Bearing", 1, 3), ("Bearing", 2, 0)}
    assert bearing.bearing[bearing.target == 2].tolist() == [0.1]
    assert ("Range", 0, 1) in told(left)
    assert ("Range", 0, 2) not in told(left)
    left = told(without(Suspect("exchange", 0, 2), RECORDS))
    assert ("Range", 0, 0) not in left
    assert ("Bearing", 2, 2) not in left
    assert ("RelativeHeading", 1, 2) in left
    assert ("Position", 2, -1) in left


def test_twice_exchanged_is_as_before():
    suspect = Suspect("exchange", 1, 3 - 1)
    apart = without_ties({1, 2}, 3, RECORDS)
    assert told(without_all([suspect, suspect], apart)) == told(apart)


def test_robots_are_left_out_as_those_who_measure_and_as_targets():
    left = told(without_robots({0}, RECORDS))
    assert left == {("Compass", 1, -1), ("Bearing", 1, 3), ("Range", 2, 4), ("Position", 2, -1)}


def test_ties_are_what_is_measured_between_a_robot_and_any_other():
    for robots in ({0}, {0, 1}, {0, 1, 2}):
        left = told(without_ties(robots, 3, RECORDS))
        assert told(RECORDS) - left == {("Bearing", 2, 0), ("Bearing", 0, 1), ("Range", 0, 2), ("RelativeHeading", 1, 0)}
    assert told(RECORDS) - told(without_ties({2}, 3, RECORDS)) == {("Bearing", 2, 0), ("Range", 0, 2)}


def test_who_has_said_something():
    found = said(RECORDS)
    assert {("compass", 0, -1), ("compass", 1, -1)} <= found
    assert {("sensor", robot, -1) for robot in range(3)} <= found
    assert {("sighting", 2, -1), ("sighting", 1, 0), ("body", -1, 4)} <= found
    assert ("compass", 2, -1) not in found
    assert ("body", -1, -1) not in found


def test_signatures_are_the_same_for_those_who_leave_out_the_same():
    only = (Range(0.0, [0, 1], [3, 4], 1.0, 0.1, 0.0),)
    kinds = [Suspect("sensor", 0), Suspect("body", None, 3), Suspect("sighting", 0, 3), Suspect("sensor", 1)]
    one, other, third, last = (signature(without(suspect, only)) for suspect in kinds)
    assert one == other == third != last


def test_one_order_does_not_depend_on_how_they_came():
    shuffled = [Bearing(0.0, [2, 1, 0, 0], [0, 3, 3, 1], [0.4, 0.3, 0.2, 0.1], 0.1), *RECORDS[2:], RECORDS[0], RECORDS[2]]
    assert signature(in_one_order(0.0, shuffled)) == signature(in_one_order(0.0, RECORDS))
    assert told(in_one_order(0.0, shuffled)) == told(RECORDS)
