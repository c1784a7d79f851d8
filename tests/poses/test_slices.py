"""Slices: the truth is in one of them, whatever happens; they say more than headings and polygons apart."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from helpers.drawn.streams import RandomStream
from helpers.worlds import World
from hypothesis import given
from hypothesis import strategies as st

from filter import AngularIntervals, Bearing, Compass, Odometry, Polygon, Range, SetMembershipFilter, Team, follow, frames_of
from filter.geometry.angles import wrap
from filter.poses.slices import COUNT, DIRECTIONS, FINEST_SLICE, NARROW_HEADING, Slices, regrouped
from filter.records.record import field_names
from filter.sets.belief import Belief
from filter.sets.predict import without_robot

seeds = st.integers(0, 2**32 - 1)


def in_a_slice(belief: Belief, robot, place, heading):
    """Return whether a pose is in one of its robot's slices, if it has any."""
    slices = belief.slices.of(robot)
    looks = slices.arcs.contains(np.full(len(slices), heading))
    return not len(slices) or bool((looks & (DIRECTIONS @ place <= slices.reach).all(axis=1)).any())


def check(belief, positions, headings):
    assert belief.regions.contains(positions).all()
    assert belief.headings.contains(headings).all()
    for robot, (place, looks) in enumerate(zip(positions, headings, strict=True)):
        assert in_a_slice(belief, robot, place, looks)


def without_some(rng, odometry):
    """Return the odometry of some robots only, or of none."""
    keep = rng.random(len(odometry.robot)) < 0.8
    columns = {name: getattr(odometry, name)[keep] for name in field_names(odometry)}
    return Odometry(odometry.start, odometry.time, **columns) if keep.any() else None


@given(seeds)
def test_the_truth_is_in_a_slice_whatever_happens(seed):
    rng = np.random.default_rng(seed)
    far = rng.choice([0.0, 0.0, 5e6], 2)
    world = World(
        rng, int(rng.integers(1, 4)), int(rng.integers(0, 4)), 4.0, str(rng.choice(["uniform", "extreme"])), origin=far
    )
    slices, cells = int(rng.choice([1, 2, 12, 40])), int(rng.choice([4, 16, 64]))
    filter_ = SetMembershipFilter(world.team, slices=slices, cells=cells, pairs=0)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings(1.0) if rng.random() < 0.5 else None)
    for _ in range(6):
        drives = rng.uniform(-0.09, 0.09, world.robots), rng.uniform(-0.3, 0.3, world.robots)  # within the limits, slip and all
        motion = without_some(rng, world.drive(*drives, 0.2))
        belief = filter_.predict(belief, world.time, motion)
        check(belief, world.positions, world.headings)
        told, dropped = world.measure(compasses=bool(rng.random() < 0.1)), rng.choice([Bearing, Range, Compass])
        belief = filter_.update(belief, [one for one in told if not isinstance(one, dropped)])
        check(belief, world.positions, world.headings)
        assert len(belief.slices) <= world.robots * max(1, min(slices, cells // 2))
        assert (belief.headings.bound[belief.slices.robot] > NARROW_HEADING).all()


@pytest.mark.parametrize("seed", range(12))
def test_it_is_also_of_streams_with_mounted_sensors_that_come_and_go(seed):
    rng = np.random.default_rng(seed)
    stream = RandomStream(rng)
    belief = SetMembershipFilter(stream.team).start(0.0, stream.start)
    frames = frames_of(stream.team, 0.0, stream.arrivals(), hold=stream.hold)
    for step in follow(SetMembershipFilter(stream.team), belief, frames, every=0.2 * (seed % 2)):
        for robot in set(range(stream.robots)) - step.belief.guarantee.away:
            drive, time = stream.drives[robot], step.frame.time
            assert in_a_slice(step.belief, robot, drive.place(time), float(drive.heading(time)))


def ranged(robots, anchors, slices, steps=40, seed=0):
    """Return the belief after robots drove about, that measured ranges and nothing else, and know no heading."""
    world = World(np.random.default_rng(seed), robots=robots, landmarks=anchors, size=5.0, sight=20.0, range=0.02)
    filter_ = SetMembershipFilter(world.team, slices=slices)
    belief = filter_.start(0.0, world.initial_sets())
    for _ in range(steps):
        motion = world.tour()
        told = [one for one in world.measure(compasses=False) if isinstance(one, Range)]
        belief = filter_.update(filter_.predict(belief, motion.time, motion), told)
        check(belief, world.positions, world.headings)
    return belief


def test_ranges_alone_teach_a_heading_as_robots_drive():
    before, after = (ranged(2, 3, slices) for slices in (0, 12))
    assert before.headings.full.all()
    assert (after.headings.bound < np.radians(30)).all()
    assert (after.regions.outer.areas < 0.8 * before.regions.outer.areas).all()


def test_where_compasses_keep_headings_narrow_no_bit_is_another():
    world = World(np.random.default_rng(3), robots=3, landmarks=1, compass=np.radians(2))
    two = [SetMembershipFilter(world.team, slices=slices) for slices in (0, 12)]
    sets = world.initial_sets()
    beliefs = [each.start(0.0, sets) for each in two]
    for motion, told in world.steps(8):
        beliefs = [each.update(each.predict(b, motion.time, motion), told) for each, b in zip(two, beliefs, strict=True)]
        assert not len(beliefs[1].slices)
        assert beliefs[0].regions.outer.vertices.tobytes() == beliefs[1].regions.outer.vertices.tobytes()
        assert beliefs[0].headings.bound.tobytes() == beliefs[1].headings.bound.tobytes()


def followed(seed, shuffled=False):
    rng, world = np.random.default_rng(seed), World(np.random.default_rng(seed), robots=3, landmarks=1)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets())
    for _ in range(4):
        motion, told = world.tour(), world.measure(compasses=False)
        told = [told[k] for k in rng.permutation(len(told))] if shuffled else told
        belief = filter_.update(filter_.predict(belief, motion.time, motion), told)
    return filter_, belief


def test_the_order_of_records_makes_no_difference():
    (_, one), (_, other) = followed(5), followed(5, shuffled=True)
    assert len(one.slices)
    assert all((a == b).all() for a, b in zip(one.slices.columns, other.slices.columns, strict=True))


def test_they_can_be_pickled():
    _, belief = followed(5)
    again = pickle.loads(pickle.dumps(belief))
    assert all((a == b).all() for a, b in zip(belief.slices.columns, again.slices.columns, strict=True))


@pytest.mark.parametrize("cells", [1, 2, 3, 4])
def test_a_filter_that_has_fewer_cells_goes_on_without_them(cells):
    world = World(np.random.default_rng(5), robots=3, landmarks=1)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets())
    for k in range(6):
        each = filter_ if k < 4 else replace(filter_, cells=cells)
        assert k != 4 or np.bincount(belief.slices.robot).max() > cells
        motion = world.tour()
        belief = each.update(each.predict(belief, motion.time, motion), world.measure(compasses=False))
        check(belief, world.positions, world.headings)


def test_a_robot_that_is_put_down_or_leaves_has_none():
    filter_, belief = followed(5)
    assert 1 in belief.slices.robot
    there = Polygon.box(np.zeros(2), np.ones(2))
    assert 1 not in filter_.placed(belief, 1, there).slices.robot
    assert 1 not in without_robot(belief, 1).slices.robot
    assert 0 in filter_.placed(belief, 1, there).slices.robot


def leaves_of(rng):
    """Return a heading, and leaves within it: of a few roots, or one, turned on purpose to where angles wrap."""
    half = float(rng.choice([np.pi, rng.uniform(0.01, np.pi)]))
    heading, count = np.array([rng.choice([np.pi, -3.0, rng.uniform(-3, 3)]), half]), int(rng.integers(1, 20))
    bound = rng.uniform(0, 1, count) * half * rng.choice([0.01, 0.3, 1.0])
    room = half - bound if half < np.pi else half  # of a whole circle, also across where it closes
    centre = wrap(heading[0] + rng.uniform(-1, 1, count) * room)
    roots = int(rng.integers(1, 6))
    return heading, (rng.integers(0, roots, count), np.stack([centre, bound], axis=1), rng.normal(size=(count, COUNT))), roots


@given(seeds)
def test_slices_hold_all_leaves_and_are_no_more_than_the_budget(seed):
    rng = np.random.default_rng(seed)
    heading, leaves, roots = leaves_of(rng)
    budget = int(rng.integers(1, 30))
    slices = regrouped(heading, leaves, roots, budget)
    assert 1 <= len(slices) <= budget
    arcs = AngularIntervals(slices[:, 0], slices[:, 1])
    for (centre, bound), reach in zip(leaves[1], leaves[2], strict=True):
        for share in (-1, 1, *rng.uniform(-1, 1, 5)):
            looks = arcs.contains(np.full(len(slices), centre + share * bound))
            assert (looks & (slices[:, 2:] >= reach).all(axis=1)).any()


def test_slices_are_no_finer_than_they_need_be_and_keep_gaps():
    heading = np.array([0.0, np.radians(20)])
    two = np.array([[-np.radians(15), np.radians(5)], [np.radians(15), np.radians(5)]])
    slices = regrouped(heading, (np.array([0, 0]), two, np.zeros((2, COUNT))), 1, 100)
    assert len(slices) == pytest.approx(2 * np.radians(10) / FINEST_SLICE, abs=2)
    assert not AngularIntervals(slices[:, 0], slices[:, 1]).contains(np.zeros(len(slices))).any()


def test_each_slice_drives_its_own_way():
    table = np.concatenate([[[0.0, 1e-3], [np.pi / 2, 1e-3]], np.zeros((2, COUNT))], axis=1)
    slices = Slices.of_table(np.array([0, 0]), table)
    ahead = Odometry(0.0, 1.0, 0, 1.0, 0.01, 0.5, 0.01, 0.0, 0.0)
    moved = slices.moved(ahead, Team(1, speed_limit=2.0, turn_rate_limit=1.0), 1.0)
    assert moved.centre == pytest.approx([0.5, np.pi / 2 + 0.5])
    for (x, y), reach in zip([(np.cos(0.25), np.sin(0.25)), (-np.sin(0.25), np.cos(0.25))], moved.reach, strict=True):
        assert reach == pytest.approx(DIRECTIONS @ [x, y], abs=0.06)
    nobody_knows = slices.moved(None, Team(1, speed_limit=2.0, turn_rate_limit=1.0), 1.0)
    assert nobody_knows.reach == pytest.approx(np.full((2, COUNT), 2.0))
    assert nobody_knows.bound == pytest.approx(np.full(2, 1.0), abs=2e-3)
