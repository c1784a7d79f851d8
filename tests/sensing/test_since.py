"""Several instants: headings, displacements and rows that are right for each of them are right at the last one."""

import numpy as np
import pytest
from helpers.worlds import World, exact_slack

from filter import AngularIntervals, Compass, Frame, Inconsistent, Odometry, Team
from filter.linear.constraints import WORLD, Constraints
from filter.sensing.headings import headings_at, looks_at_a_glance
from filter.sensing.motion import displacements
from filter.sensing.readings import Readings
from filter.sensing.since import Since

SEEDS = range(6)
ROUNDING = 1e-12  # of true positions, which are sums [m]


def instants(seed, count=4):
    """Return a world after some instants, what is known of the way, its readings, and the true poses from the first on."""
    rng = np.random.default_rng(seed)
    world = World(rng, robots=3, errors="extreme" if seed % 2 else "uniform")
    headings, poses, frames = world.initial_headings(), [(world.positions, world.headings)], []
    for _ in range(count):
        motion = world.tour(float(rng.uniform(0.05, 0.4)))
        frames.append(Frame(world.time, motion, [record for record in world.measure() if rng.random() < 0.7]))
        poses.append((world.positions, world.headings))
    since = Since.of(world.team, headings, 0.0, frames)
    records = [record for frame in frames for record in frame.measurements]
    return world, since, Readings.of(world.time, records, since), poses


@pytest.mark.parametrize("seed", SEEDS)
def test_true_headings_are_in_the_arcs_of_every_instant_and_of_the_beginning(seed):
    world, since, readings, poses = instants(seed)
    looks, _ = looks_at_a_glance(since, readings)
    assert looks.contains(np.concatenate([headings for _, headings in poses])).all()
    assert len(looks) == 5 * world.robots


@pytest.mark.parametrize("seed", SEEDS)
def test_rows_that_hold_at_an_instant_hold_now_after_the_moves(seed):
    """Rows on robots and on pairs, which the truth of their instant just satisfies, in every direction."""
    _, since, readings, poses = instants(seed)
    _, moves = looks_at_a_glance(since, readings)
    rng, count = np.random.default_rng(seed), 200
    at, way = rng.integers(-1, 4, count), rng.uniform(-np.pi, np.pi, count)
    i, j = np.sort(np.stack([rng.integers(-1, 2, count), rng.integers(1, 3, count)]), axis=0)
    i[i == j], at = WORLD, np.sort(at)
    normal = np.stack([np.cos(way), np.sin(way)], axis=1)
    then = np.stack([poses[k + 1][0] for k in at])
    place = then[np.arange(count), j] - np.where((i == WORLD)[:, None], 0.0, then[np.arange(count), i])
    rows = Constraints(i, j, normal, (normal * place).sum(axis=1), np.arange(count))
    after = moves.moved(rows, at[rows.source])
    now = poses[-1][0]
    for k in range(count):
        apart = now[after.j[k]] - (now[after.i[k]] if after.i[k] != WORLD else 0.0)
        assert exact_slack(after.normal[k], after.offset[k], apart) >= -ROUNDING
    last = at[rows.source] == 3
    assert after.offset[last] == pytest.approx(rows.offset[last], abs=ROUNDING)
    assert (after.offset >= rows.offset - ROUNDING).any()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_way_to_a_target_was_another_one_by_no_more_than_is_said(seed):
    world, since, readings, poses = instants(seed)
    _, moves = looks_at_a_glance(since, readings)
    robot, target, at = (each.ravel() for each in np.meshgrid([0, 1, 2], [0, 1, 2, 3], range(4), indexing="ij"))
    by, radius = moves.between(robot, target, at)
    for k in range(len(robot)):
        ways = [np.concatenate([place, world.team.landmarks]) for place in (poses[at[k] + 1][0], poses[-1][0])]
        then, now = (bodies[target[k]] - bodies[robot[k]] for bodies in ways)
        assert np.hypot(*(now - then - by[k])) <= radius[k] + ROUNDING


@pytest.mark.parametrize("seed", SEEDS)
def test_discs_since_an_instant_are_the_sums_of_those_on_the_way(seed):
    _, since, readings, _ = instants(seed)
    _, moves = looks_at_a_glance(since, readings)
    (centre, radius), (middle, each, _) = moves.discs, moves.sets.discs
    for k in range(5 * moves.robots):
        assert centre[k] == pytest.approx(middle[k :: moves.robots].sum(axis=0), abs=1e-15)
        assert each[k :: moves.robots].sum() <= radius[k] <= each[k :: moves.robots].sum() + 1e-10


def test_one_instant_is_a_motion():
    team = Team(2, speed_limit=0.5, turn_rate_limit=1.0)
    arcs, driven = AngularIntervals([0.3, -2.0], [0.1, 0.2]), Odometry(0.0, 0.5, 1, 0.2, 0.01, 0.1, 0.02, 0.03, 0.004)
    since = Since.of(team, arcs, 0.0, [Frame(0.5, driven)])
    directions = np.stack([np.cos(np.arange(7.0)), np.sin(np.arange(7.0))], axis=1)
    for robot in (0, 1):
        who = np.full(7, robot)
        once = displacements(driven, arcs, team, 0.5).support(who, directions)
        assert since.moves(arcs[[0, 1, 0, 1]]).support(who, directions).tolist() == once.tolist()


def test_compasses_that_odometry_excludes_are_a_conflict():
    team = Team(1, turn_rate_limit=0.1)
    frames = [Frame(time, None, [Compass(time, 0, heading, 0.1)]) for time, heading in ((1.0, 0.0), (2.0, 1.0))]
    since = Since.of(team, AngularIntervals.circles(1), 0.0, frames)
    readings = Readings.of(2.0, [record for frame in frames for record in frame.measurements], since)
    with pytest.raises(Inconsistent, match="heading of robot 0"):
        headings_at(since, readings, AngularIntervals.circles(0))
