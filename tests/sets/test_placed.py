"""A robot that joins, comes back or is put down: where it is then is what is known of it, and the others stay as they are."""

import numpy as np
import pytest
from helpers.worlds import World, escapes

from filter import AngularIntervals, InvalidInput, Polygon, SetMembershipFilter, Source, Team

DOCK = Polygon.from_vertices([[5, 5], [6, 5], [5, 6]])


def after_some_steps(seed=0):
    world = World(np.random.default_rng(seed), robots=3)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(3):
        belief = filter_.update(filter_.predict(belief, world.time, motion), records)
    return world, filter_, belief


def test_the_set_and_the_arc_are_what_is_known_of_it():
    _, filter_, belief = after_some_steps()
    after = filter_.placed(belief, 1, DOCK, AngularIntervals([1.0], [0.1]))
    assert after.regions[1].outer.area == pytest.approx(0.5)
    assert (after.headings.centre[1], after.headings.bound[1]) == (1.0, 0.1)
    assert [after.regions[k].outer.area for k in (0, 2)] == pytest.approx([belief.regions[k].outer.area for k in (0, 2)])
    assert after.headings.bound[[0, 2]].tolist() == belief.headings.bound[[0, 2]].tolist()
    assert after.causes(1, 0) == (Source("initial set", belief.time, 1),)
    assert after.time == belief.time
    assert filter_.placed(belief, 1, DOCK).headings.bound[1] == np.pi


@pytest.mark.parametrize("seed", range(3))
def test_the_truth_stays_inside_afterwards(seed):
    world, filter_, belief = after_some_steps(seed)
    world.positions = world.positions.copy()
    world.positions[0] = [20.0, 20.0]  # somebody carries it away
    belief = filter_.placed(belief, 0, Polygon.box([19, 19], [21, 21]))
    for motion, records in world.steps(4):
        belief = filter_.update(filter_.predict(belief, world.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []


def test_nowhere_in_particular_is_the_arena():
    team = Team(2, arena=[[0, 0], [9, 9]])
    filter_ = SetMembershipFilter(team)
    belief = filter_.start(0.0, [DOCK, DOCK])
    assert filter_.placed(belief, 0, None).regions.outer.areas == pytest.approx([81, 0.5])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((3, DOCK), "robot: whole numbers from 0 to 2"),
        ((0, [[0, 0], [1, 1]]), "initial polygon"),
        ((0, None), "closed arena"),
        ((0, DOCK, 0.5), "initial headings, arcs"),
        ((0, DOCK, AngularIntervals.circles(2)), "an initial arc"),
    ],
)
def test_what_is_no_place_is_refused(arguments, said):
    _, filter_, belief = after_some_steps()
    with pytest.raises(InvalidInput, match=said):
        filter_.placed(belief, *arguments)
