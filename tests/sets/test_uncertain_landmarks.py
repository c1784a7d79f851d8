"""Landmarks that are known only within a set, and stay where they are: robots that can neither drive nor turn."""

import numpy as np
import pytest
from helpers.teams import odometry
from scipy.optimize import linprog

from filter import AngularIntervals, Bearing, Compass, Frame, Polygon, Position, Range, SetMembershipFilter, Team, follow

ROBOT, ANCHOR = 0, 1
WITHIN = Polygon.box([3.8, -0.2], [4.2, 0.2])  # where the anchor is, as far as anybody knows
START = Polygon.box([-1, -1], [1, 1])
ARENA = [[-10, -10], [10, 10]]
COMPASS, BEARING, RANGE = np.radians(1.0), np.radians(2.0), 0.05
AROUND = np.linspace(0, 2 * np.pi, 32, endpoint=False)


def team(robots=2, mark=ANCHOR):
    """Return robots of which one is a landmark."""
    limits = [0.0 if robot == mark else 0.5 for robot in range(robots)]
    return Team(robots, arena=ARENA, speed_limit=limits, turn_rate_limit=limits)


def seen(truth, anchor, errors=(0.0, 0.0, 0.0), robot=ROBOT, *, mark=ANCHOR, time=0.0):
    """Return what a robot that looks east measures of a landmark; errors are in shares of their bounds."""
    way, (by_compass, by_bearing, by_range) = np.subtract(anchor, truth), errors
    look = Compass(time, robot, by_compass * COMPASS, COMPASS)
    direction = Bearing(time, robot, mark, np.arctan2(way[1], way[0]) + by_bearing * BEARING, BEARING)
    return [look, direction, Range(time, robot, mark, np.hypot(*way) + by_range * RANGE, RANGE, 0.0)]


def optimum(records, normals):
    """Return supports of robot and anchor by linear programs over both: a sector, the chord inside it, and its tangents."""
    look, sight, distance = records
    middle, wide = look.heading[0] + sight.bearing[0], COMPASS + BEARING
    sides = [(np.sin(middle - wide), -np.cos(middle - wide), 0.0), (-np.sin(middle + wide), np.cos(middle + wide), 0.0)]
    far, near = distance.range[0] + RANGE, (distance.range[0] - RANGE) * np.cos(wide)
    tangents = [(np.cos(way), np.sin(way), far) for way in middle + wide * np.linspace(-1, 1, 9)]
    rows = np.array([*sides, *tangents, (-np.cos(middle), -np.sin(middle), -near)])
    box = [*START.bounds, *WITHIN.bounds]
    limits = [(box[2 * body][axis], box[2 * body + 1][axis]) for body in range(2) for axis in range(2)]
    found = []
    for body in range(2):
        costs = (np.concatenate([np.zeros(2 * body), -normal, np.zeros(2 - 2 * body)]) for normal in normals)
        programs = (linprog(cost, np.hstack([-rows[:, :2], rows[:, :2]]), rows[:, 2], bounds=limits) for cost in costs)
        found.append(np.array([-each.fun for each in programs]))
    return found


def area_of(normals, offsets):
    return Polygon.from_half_planes(normals, offsets, *ARENA).area


@pytest.mark.parametrize("seed", range(6))
def test_robot_and_landmark_are_as_small_as_an_independent_optimum_nearly(seed):
    """The first one is a case of others: an anchor that is 0.15 m from where it is thought to be."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform(-1, 1, 2) if seed else np.zeros(2)
    anchor = rng.uniform([3.8, -0.2], [4.2, 0.2]) if seed else np.array([4.15, 0.1])
    records = seen(truth, anchor, rng.uniform(-1, 1, 3) if seed else (0, 0, 0))
    filter_ = SetMembershipFilter(team())
    belief = filter_.update(filter_.start(0.0, [START, WITHIN]), records)
    assert belief.regions.contains(np.array([truth, anchor])).all()
    normals = np.stack([np.cos(AROUND), np.sin(AROUND)], axis=1)
    for region, supports in zip(belief.regions, optimum(records, normals), strict=True):
        assert (region.outer.support(normals) >= supports - 1e-6).all(), "the optimum is inside"
        assert region.outer.area <= 1.1 * area_of(normals, supports)


def test_taken_for_exact_it_excludes_the_truth():
    """So much is an anchor worth that is known to 0.2 m: what is told in centimetres of it is wrong."""
    exact = SetMembershipFilter(Team(1, [WITHIN.centroid], arena=ARENA))
    belief = exact.update(exact.start(0.0, [START]), seen([0.0, 0.0], [4.15, 0.1]))
    assert not belief.regions[0].outer.contains([0.0, 0.0])


def test_it_stays_for_a_minute_of_which_nothing_is_said():
    filter_ = SetMembershipFilter(team())
    belief = filter_.update(filter_.start(0.0, [START, WITHIN]), seen([0.0, 0.0], [4.15, 0.1]))
    before, lost = belief.regions[ANCHOR].outer, belief.regions[ROBOT].outer.area
    for time in np.arange(1.0, 61.0):
        belief = filter_.predict(belief, time)
        belief = filter_.update(belief) if time % 10 == 0 else belief
    after = belief.regions[ANCHOR].outer
    assert before.area <= WITHIN.area
    assert after.area <= before.area * (1 + 1e-6)
    assert (after.support(before.normals) <= before.support(before.normals) + 1e-9).all()
    assert after.contains([4.15, 0.1])
    assert belief.regions[ROBOT].outer.area > 10 * lost, "a robot does not stay"


@pytest.mark.parametrize("errors", [(0, 0, 0), (1, -1, 1), (-1, 1, -1)])
def test_robots_whose_places_are_known_sharpen_it_and_it_tells_others_then(errors):
    anchor, places = np.array([4.15, 0.1]), np.array([[2.0, 0.0], [4.0, -2.0], [5.5, 2.0]])
    filter_, lost = SetMembershipFilter(team(5, mark=4)), np.array([-0.5, 0.3])
    begin = filter_.start(0.0, [Polygon.box(place - 0.01, place + 0.01) for place in places] + [START, WITHIN])
    alone = filter_.update(begin, seen(lost, anchor, errors, robot=3, mark=4))
    fixed = [record for robot, place in enumerate(places) for record in seen(place, anchor, errors, robot, mark=4)]
    sharp = filter_.update(filter_.predict(filter_.update(begin, fixed), 5.0))
    assert sharp.regions[4].outer.area < 0.1 * WITHIN.area
    assert sharp.regions[4].outer.contains(anchor)
    told = filter_.update(sharp, seen(lost, anchor, errors, robot=3, mark=4, time=5.0))
    assert told.regions[3].outer.contains(lost)
    assert told.regions[3].outer.area < 0.7 * alone.regions[3].outer.area


@pytest.mark.parametrize("seed", range(4))
def test_whatever_is_measured_of_it_all_are_inside(seed):
    """Also one that is known exactly, on a line, in a corner of the arena, and while robots drive about it."""
    rng = np.random.default_rng(seed)
    half = np.array([[0.0, 0.0], [0.3, 0.0], [0.2, 0.2], [1.0, 0.5]][seed])
    anchor = [np.array([10.0, 10.0]), rng.uniform(-5, 5, 2)][seed > 0]
    middle = np.clip(anchor + rng.uniform(-half, half), -10, 10)
    low, high = np.minimum(middle - half, anchor), np.maximum(middle + half, anchor)
    place, look = rng.uniform(-5, 5, 2), 0.0
    filter_ = SetMembershipFilter(team())
    belief = filter_.start(0.0, [Polygon.box(place - 1, place + 1), Polygon.box(low, high)], AngularIntervals([0, 0], [0.1, 3]))
    frames, truths = [], []
    for time in np.arange(1.0, 13.0):
        distance = rng.uniform(-0.4, 0.4)
        driven = odometry(time - 1, time, ROBOT, distance + 0.01 * rng.uniform(-1, 1), distance_bound=0.01, slip_bound=1e-6)
        place = place + distance * np.array([np.cos(look), np.sin(look)])
        records = seen(place, anchor, rng.choice([-1, 0, 1], 3), time=time)[rng.integers(0, 2) :]
        frames.append(Frame(time, driven, records + [Position.disc(time, ROBOT, place, 0.5)] * int(time == 6)))
        truths.append(np.array([place, anchor]))
    for step, truth in zip(follow(filter_, belief, frames), truths, strict=True):
        assert step.belief.regions.contains(truth).all()
        assert step.belief.regions[ANCHOR].outer.area <= np.prod(high - low) * (1 + 1e-9) + 1e-12
