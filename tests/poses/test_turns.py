"""Robots one after the other: what is found is the same however many are found at a time, and nobody sees those after it."""

from itertools import count

import numpy as np
import pytest
from helpers.worlds import World

from filter import SetMembershipFilter
from filter.poses import cells
from filter.poses.cells import Most, Scene, Told
from filter.poses.slices import Slices
from filter.sensing.readings import Readings

ROBOTS = 5


def scene(seed=0):
    """Return where robots can be that see one another and a landmark, and where they are."""
    world = World(np.random.default_rng(seed), robots=ROBOTS, landmarks=1)
    headings = world.initial_headings(0.5)
    belief = SetMembershipFilter(world.team).start(0.0, world.initial_sets(), headings)
    told = Told.of(Readings.of(0.0, world.measure(compasses=False)), headings, np.radians(30))
    return Scene(belief.polytope, belief.sources, told, world.team.landmarks, Slices.none()), world


def arrays(found):
    return [*found.trees, *found[1:]]


@pytest.mark.parametrize("at_a_time", [1, 2, 3])
def test_it_makes_no_difference_how_many_are_found_at_a_time(at_a_time, monkeypatch):
    robots, most = np.arange(ROBOTS), Most(16, 4)
    together, nowhere = scene()[0].in_cells(robots, most)
    monkeypatch.setattr(cells, "AT_A_TIME", at_a_time)
    apart, nowhere_apart = scene()[0].in_cells(robots, most)
    assert nowhere == nowhere_apart == -1
    for one, other in zip(arrays(together.found), arrays(apart.found), strict=True):
        assert one.tobytes() == other.tobytes()


def test_when_time_is_over_those_are_left_out_that_come_later(monkeypatch):
    monkeypatch.setattr(cells, "AT_A_TIME", 2)
    looks = count()
    some, nowhere = scene()[0].in_cells(np.arange(ROBOTS), Most(16, 4), lambda: next(looks) >= 2)
    every, _ = scene()[0].in_cells(np.arange(ROBOTS), Most(16, 4))
    assert nowhere == -1
    assert some.robot.tolist() == [0, 1, 2, 3]
    for one, other in zip(arrays(some.found), arrays(every.found), strict=True):
        assert one.tobytes() == other[:4].tobytes()


@pytest.mark.parametrize("seed", range(5))
def test_the_truth_is_in_all_of_them(seed):
    whole, world = scene(seed)
    found, _ = whole.in_cells(np.arange(ROBOTS), Most(16, 4))
    for robot, case in enumerate(found):
        assert (case.rows[:, :2] @ world.positions[robot] <= case.rows[:, 2]).all()
    assert found.headings.contains(world.headings).all()
    assert len(found.constraints(np.arange(ROBOTS))) == sum(len(case.rows) for case in found)
