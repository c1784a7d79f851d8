"""The table of what produced the rows."""

import numpy as np
import pytest

from filter import InvalidInput, Sensor, Team
from filter.linear.sources import KINDS, NOBODY, Source, Sources, in_order


def test_a_table_grows_by_one_entry_for_each_robot_or_target():
    table, first = Sources().extended("compass", 1.0, [0, 1])
    table, second = table.extended("bearing", 2.0, 1, [4, 5])
    assert (first.tolist(), second.tolist()) == ([0, 1], [2, 3])
    assert [table[k] for k in range(4)] == [
        Source("compass", 1.0, 0, None),
        Source("compass", 1.0, 1, None),
        Source("bearing", 2.0, 1, 4),
        Source("bearing", 2.0, 1, 5),
    ]
    assert table.target.tolist() == [NOBODY, NOBODY, 4, 5]
    assert len(table) == 4
    assert len(Sources()) == 0


def test_a_table_that_grows_stays_as_it_was():
    table, _ = Sources().extended("range", 0.0, [3])
    longer, _ = table.extended("range", 1.0, [3])
    assert (len(table), len(longer)) == (1, 2)
    with pytest.raises(ValueError, match="read-only"):
        longer.robot[0] = 7


def test_some_sources_are_selected():
    table, _ = Sources().extended("range", 1.5, [0, 1, 2], [5, 6, 7])
    few = table.select(np.array([2, 0]))
    assert [few[k] for k in range(2)] == [Source("range", 1.5, 2, 7), Source("range", 1.5, 0, 5)]


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_what_it_is_called(kind):
    table, (number,) = Sources().extended(kind, 0.5, [2])
    assert table[number] == Source(kind, 0.5, 2)
    assert str(table[number]) == f"{kind} of robot 2 at 0.500 s"


def test_a_source_says_who_what_and_when():
    assert str(Source("range", 1.5, 2, 7)) == "range of robot 2 to 7 at 1.500 s"
    assert str(Source("range", 1.5, 2, 0)) == "range of robot 2 to 0 at 1.500 s"
    assert str(Source("range", 1.5, 2, 0, 1)) == "range of robot 2 to 0 by sensor 1 at 1.500 s"
    assert str(Source("position", 1.5, 2, sensor=0)) == "position of robot 2 by sensor 0 at 1.500 s"


def test_a_source_has_the_names_of_its_team():
    team = Team(["alice", "bob"], {"gate": [0, 0]}, sensors=[Sensor("uwb"), Sensor("gps")])
    assert Source("range", 0.1, 0, 2, 0).named(team) == "range of alice to gate by uwb at 0.100 s"
    assert Source("position", 0.1, 1, sensor=1).named(team) == "position of bob by gps at 0.100 s"
    assert Source("pair", 0.1, 0, 1).named(team) == "pair of alice to bob at 0.100 s"
    with pytest.raises(InvalidInput, match="a body"):
        Source("range", 0.1, 0, 3).named(team)


def test_two_sensors_are_two_sources():
    table, numbers = Sources().extended("range", 0.1, [0, 0, 0], 2, [-1, 0, 1])
    sources = [table[k] for k in numbers.tolist()]
    assert sources == [Source("range", 0.1, 0, 2), Source("range", 0.1, 0, 2, 0), Source("range", 0.1, 0, 2, 1)]
    assert sorted([sources[k] for k in (2, 0, 1)], key=in_order) == sources
    assert table.select(np.array([2]))[0] == sources[2]
