"""Windows: who is in one, which rows, and the program that they make, against the slow and obvious way."""

import numpy as np
import pytest
from helpers.programs import links_of, merged_team, random_polytope, team_program
from helpers.walks import dense

from filter.errors import InvalidInput
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.window import Window, members_of, rows_in


def neighbours(polytope):
    rows = polytope.constraints
    near = {robot: set() for robot in range(len(polytope.lower))}
    for i, j in zip(rows.i.tolist(), rows.j.tolist(), strict=True):
        if i != WORLD:
            near[i].add(j)
            near[j].add(i)
    return near


def within(near, robots, hops):
    """Return who is at most so many pairs away from some robots."""
    found = set(robots)
    for _ in range(hops):
        found |= {other for robot in found for other in near[robot]}
    return found


def nobody(polytope):
    return np.full(len(polytope.lower), -1)


@pytest.mark.parametrize("values", [{"hops": 0}, {"robots": 1}, {"hops": 1.5}, {"robots": "all"}])
def test_a_window_too_small_is_refused(values):
    with pytest.raises(InvalidInput, match="of a window"):
        Window(**values)


def test_only_the_window_of_everybody_leaves_nobody_out():
    assert Window.everybody().leaves_nobody_out
    assert Window.everybody() == Window.everybody()
    for other in (Window(), Window(10**6, 10**6), Window(Window.everybody().hops, 5), Window(5, Window.everybody().robots)):
        assert not other.leaves_nobody_out


@pytest.mark.parametrize("seed", range(4))
def test_the_members_are_the_nearest_and_no_more_than_there_is_room_for(seed):
    polytope = random_polytope(np.random.default_rng(seed), 9, 14)
    near, who = neighbours(polytope), links_of(polytope)
    for robot in range(9):
        for hops in (1, 2, 3, 99):
            wanted = within(near, {robot}, hops)
            place = nobody(polytope)
            members = members_of(WORLD, robot, hops, 99, who, place)
            assert members[0] == robot
            assert set(members.tolist()) == wanted
            assert len(members) == len(wanted)
            assert (place[members] == np.arange(len(members))).all()
            assert (place >= 0).sum() == len(members)
            for most in (2, 3, 5):
                few = members_of(WORLD, robot, hops, most, who, nobody(polytope))
                assert few.tolist() == members[:most].tolist()
        distance = [min(h for h in range(10) if member in within(near, {robot}, h)) for member in members.tolist()]
        assert distance == sorted(distance)


def test_a_pair_comes_first_in_its_own_window():
    polytope = random_polytope(np.random.default_rng(3), 9, 14)
    near, who = neighbours(polytope), links_of(polytope)
    for i, j in ((0, 5), (2, 8)):
        members = members_of(i, j, 1, 99, who, nobody(polytope))
        assert members[:2].tolist() == [j, i]
        assert set(members.tolist()) == within(near, {i, j}, 1)
        assert members_of(i, j, 3, 2, who, nobody(polytope)).tolist() == [j, i]


def test_rows_of_members_are_those_on_them_alone_and_between_them():
    polytope = merged_team(1)
    rows, who = polytope.constraints, links_of(polytope)
    for chosen in ([2], [4, 1], [0, 3, 2], [4, 3, 2, 1, 0]):
        place = nobody(polytope)
        place[chosen] = np.arange(len(chosen))
        wanted = [k for k in range(len(rows)) if {int(rows.i[k]), int(rows.j[k])} <= {WORLD, *chosen}]
        assert sorted(rows_in(np.array(chosen), place, who).tolist()) == wanted


def test_links_know_who_has_no_rows():
    rows = Constraints(np.array([1, WORLD]), np.array([3, 3]), np.eye(2), np.ones(2), np.zeros(2, dtype=int))
    who = links_of(Polytope(rows, np.zeros((5, 2)), np.ones((5, 2))))
    assert who.own_first.tolist() == [0, 0, 0, 0, 1, 1]
    assert [np.diff(who.near_first).tolist(), who.near.tolist()] == [[0, 1, 0, 1, 0], [3, 1]]


def test_links_have_the_mates_of_each_robot_in_order():
    i, j = np.triu_indices(4, 1)
    rows = Constraints(i, j, np.tile([[1.0, 0.0]], (6, 1)), np.ones(6), np.zeros(6, dtype=int))
    who = links_of(Polytope(rows, np.zeros((4, 2)), np.ones((4, 2))))
    assert np.split(who.near, who.near_first[1:-1])[2].tolist() == [0, 1, 3]
    assert np.split(who.near_pair, who.near_first[1:-1])[2].tolist() == [1, 3, 5]


@pytest.mark.parametrize("members", [[0, 1, 2, 3], [2, 0]])
@pytest.mark.parametrize("seed", range(3))
def test_the_program_is_the_teams_in_units_of_its_boxes(seed, members):
    polytope = random_polytope(np.random.default_rng(seed), 4, 50, thin=5)
    program, rows = team_program(polytope, members), polytope.constraints
    assert program.centre == pytest.approx(((polytope.lower + polytope.upper) / 2)[members].ravel())
    assert program.radius == pytest.approx(((polytope.upper - polytope.lower) / 2)[members].ravel())
    variables = 2 * len(members)
    count, matrix = len(program.number), dense(program.rows, variables)
    assert len(matrix) == count + 2 * variables
    assert np.abs(matrix[:count]).sum(axis=1) == pytest.approx(1)
    assert matrix[count:].tolist() == [*np.eye(variables).tolist(), *(-np.eye(variables)).tolist()]
    A = rows.matrix(4).toarray()[:, [2 * member + m for member in members for m in range(2)]]
    inside = [k for k in range(len(rows)) if {int(rows.i[k]), int(rows.j[k])} <= {WORLD, *members}]
    room = np.abs(A) @ program.radius
    slack = rows.offset - A @ program.centre
    assert sorted(program.number.tolist()) == [k for k in inside if slack[k] < room[k]]  # those that the box does not imply
    assert count < len(inside)
    for at, row in enumerate(program.number.tolist()):
        assert program.size[at] == pytest.approx(room[row])
        assert matrix[at] == pytest.approx(A[row] * program.radius / room[row])
        assert 0 < program.rows.offset[at] - slack[row] / room[row] < 1e-9  # moved outward, all by different amounts
    assert len(set((program.rows.offset[count:] - 1).tolist())) == 2 * variables
