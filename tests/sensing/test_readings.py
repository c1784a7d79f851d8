"""What was measured at one time, in one order: whatever the records, the belief is the same to the last bit."""

import numpy as np
import pytest
from helpers.teams import begun
from helpers.worlds import World

from filter import Bearing, Compass, Position, Range, RelativeHeading
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.linear.sources import Source, Sources
from filter.records.record import field_names
from filter.sensing.readings import KIND_OF, Readings


def pieces(rng, records):
    """Return the same measurements one by one in any order, some of them twice."""
    single = []
    for record in records:
        for k in range(len(record.robot)):
            values = {name: getattr(record, name)[k] for name in field_names(record)}
            single += [type(record)(record.time, **values)] * int(rng.integers(1, 3))
    return [single[k] for k in rng.permutation(len(single))]


@pytest.mark.parametrize("seed", range(6))
def test_shuffled_split_and_repeated_records_give_the_same_bits(seed):
    rng = np.random.default_rng(seed)
    world = World(rng, robots=4, landmarks=2, errors="extreme" if seed % 2 else "uniform")
    estimator, records = SetMembershipFilter(world.team), world.measure()
    if seed % 3 == 0:  # ranges alone, from anywhere: in cells and in rounds
        records = records[2:]
    before = begun(estimator, world)
    one, *others = (estimator.update(before, some) for some in (records, pieces(rng, records), records[::-1]))
    for other in others:
        assert one.constraints.offset.tobytes() == other.constraints.offset.tobytes()
        assert one.constraints.normal.tobytes() == other.constraints.normal.tobytes()
        assert one.headings.bound.tobytes() == other.headings.bound.tobytes()
        assert one.regions.outer.vertices.tobytes() == other.regions.outer.vertices.tobytes()


def test_a_negative_zero_is_zero():
    one, other = (Readings.of(0.0, [Bearing(0.0, 0, 1, value, 0.1), Bearing(0.0, 0, 1, 0.0, 0.1)]) for value in (0.0, -0.0))
    assert one.bearings.bearing.tobytes() == other.bearings.bearing.tobytes() == np.zeros(1).tobytes()


def test_what_differs_in_any_column_stays():
    records = [Range(0.0, [0, 0, 1, 0], [1, 1, 0, 1], [1.0, 1.0, 1.0, 2.0], [0.1, 0.2, 0.1, 0.1], 0.0)]
    assert len(Readings.of(0.0, records).ranges.robot) == 4
    assert len(Readings.of(0.0, records * 3).ranges.robot) == 4


def test_bearings_ranges_and_cells_are_entered_in_order_and_what_is_of_headings_is_not():
    records = [Compass(1.0, [0, 1], [0.1, 0.2], 0.1), Range(1.0, [1, 0], [0, 2], 1.0, 0.1, 0), Bearing(1.0, 0, 1, 0.3, 0.1)]
    records += [Position.half_plane(1.0, 1, [1, 0], 2.0), RelativeHeading(1.0, 0, 1, 0.1, 0.1)]
    before, _ = Sources().extended("initial set", 0.0, [0, 1])
    table, numbers = Readings.of(1.0, records).numbered(before, 2)
    expected = [
        ("bearing", 0, 1),
        ("range", 0, 2),
        ("range", 1, 0),
        ("position", 1, None),
        ("cells", 0, None),
        ("cells", 1, None),
    ]
    assert [table[k] for k in numbers] == [Source(kind, 1.0, robot, target) for kind, robot, target in expected]
    assert set(KIND_OF) == {Compass, Bearing, Range, Position, RelativeHeading}


def test_who_is_concerned_is_who_measured_and_who_was_measured():
    records = [Compass(1.0, [0, 1], 0.1, 0.1), Bearing(1.0, [0, 1], [1, 2], 0.3, 0.1), Range(1.0, 2, 0, 1.0, 0.1, 0)]
    found = Readings.of(1.0, records).concerning(0)
    expected = [("compass", 0, None), ("bearing", 0, 1), ("range", 2, 0)]
    assert found == [Source(kind, 1.0, robot, target) for kind, robot, target in expected]


def test_no_record_is_no_reading():
    nothing = Readings.of(0.0, [])
    assert [len(record.robot) for record in nothing.records] == [0, 0, 0, 0, 0]
    assert not nothing.tie_robots(3)
    assert nothing.ranges.robot.dtype == np.int64
