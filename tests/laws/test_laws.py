"""What holds for every team, every error within its bound, and every order of events."""

import dataclasses

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.worlds import World, escapes, feasible, of_robot, unit

from filter import Bearing, Compass, Odometry, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope, prune
from filter.linear.solvers import deepest_point, workspace
from filter.projection.proved import position
from filter.projection.search import project
from filter.projection.stop import Stop
from filter.team import Team

# A search that goes on until nothing is left to find.
TIGHT = Stop(performance_ratio=1 - 1e-9, searches=120)
# What a solver's tolerance leaves between two exact projections [m].
SAME = 1e-6
# A budget that drops next to nothing.
MANY = 400

WORLDS = {
    "plain": {},
    "extreme": {"errors": "extreme"},
    "one robot": {"robots": 1, "landmarks": 2},
    "two robots": {"robots": 2, "landmarks": 0},
    "six robots": {"robots": 6, "landmarks": 0, "errors": "extreme"},
    "no landmarks": {"landmarks": 0},
    "three landmarks": {"landmarks": 3, "errors": "extreme"},
    "near-sighted": {"sight": 1.0},
    "precise": {"bearing": 1e-6, "range": 1e-6, "compass": 1e-6, "errors": "extreme"},
    "coarse": {"bearing": 1.4, "range": 0.9, "compass": 3.0},
    "far away": {"origin": np.array([5e5, 5e6]), "errors": "extreme"},
    "crowded": {"size": 0.01},
}


def supports(polygon):
    return polygon.support(unit(np.linspace(-np.pi, np.pi, 48, endpoint=False)))


def run(world, steps=3, compasses=True, backwards=False, odometry=True, **options):
    """Yield every belief on the way, after each start, prediction and update."""
    estimator = SetMembershipFilter(world.team, **options)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    yield belief
    for _ in range(steps):
        motion = world.move(backwards=backwards)
        belief = estimator.predict(belief, motion.time, motion if odometry else None)
        yield belief
        belief = estimator.update(belief, world.measure(compasses))
        yield belief


@pytest.mark.parametrize("compasses", [True, False])
@pytest.mark.parametrize("backwards", [True, False])
@pytest.mark.parametrize("name", WORLDS)
def test_the_truth_is_inside_whatever_happens(name, backwards, compasses):
    for seed in range(2):
        world = World(np.random.default_rng(seed), **WORLDS[name])
        for belief in run(world, backwards=backwards, compasses=compasses):
            assert escapes(belief, world.positions, world.headings) == []


@pytest.mark.parametrize("seed", range(3))
def test_the_truth_is_inside_after_a_long_way_with_tight_budgets(seed):
    world = World(np.random.default_rng(seed), robots=3, errors="extreme")
    for belief in run(world, steps=25, backwards=True, rows_per_robot=4, rows_per_pair=4, stop=Stop(searches=4)):
        assert escapes(belief, world.positions, world.headings) == []


def test_the_truth_is_inside_without_any_odometry():
    for seed in range(3):
        world = World(np.random.default_rng(seed))
        for belief in run(world, odometry=False):
            assert escapes(belief, world.positions, world.headings) == []


@pytest.mark.parametrize("heading", [np.pi, -np.pi, np.nextafter(-np.pi, 0), 0.0])
def test_headings_at_the_seam_are_no_trouble(heading):
    world = World(np.random.default_rng(0), errors="extreme")
    world.headings[:] = wrap(heading)
    for belief in run(world):
        assert escapes(belief, world.positions, world.headings) == []


def test_turning_on_the_spot_keeps_the_truth():
    world = World(np.random.default_rng(1), robots=2)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    zero = np.zeros(2)
    for step in range(1, 8):
        world.headings, world.time = wrap(world.headings + 1.0), 0.1 * step
        turned = Odometry(belief.time, world.time, np.arange(2), zero, zero, zero + 1.0, zero + 1e-12, zero, zero)
        belief = estimator.update(estimator.predict(belief, world.time, turned), world.measure())
        assert escapes(belief, world.positions, world.headings) == []


def test_turns_about_nothing_change_no_region():
    world = World(np.random.default_rng(1), robots=2)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    turned = estimator.predict(belief, 1.0, Odometry(0.0, 1.0, [0, 1], 0.0, 0.0, 3.0, 0.5, 0.1, 0.0))
    for before, after in zip(belief.regions, turned.regions, strict=True):
        assert supports(after.outer) == pytest.approx(supports(before.outer), abs=1e-12)


@pytest.mark.parametrize("name", ["plain", "extreme", "no landmarks", "precise", "far away"])
def test_what_is_inside_is_within_what_is_outside(name):
    for seed in range(3):
        world = World(np.random.default_rng(seed), **WORLDS[name])
        for belief in run(world):
            for region in belief.regions:
                if region.inner is not None:
                    rounding = 1e-12 * np.abs(region.outer.vertices).max()
                    assert (supports(region.inner) <= supports(region.outer) + rounding).all()
                    assert 0 <= region.performance_ratio <= 1


@pytest.mark.parametrize("seed", range(6))
def test_inner_points_are_possible_in_exact_arithmetic(seed):
    world = World(np.random.default_rng(seed), robots=2)
    *_, belief = run(world, steps=1)
    program = belief.polytope.program()
    deepest = deepest_point(program, "piqp")
    work = workspace(program, "piqp")
    points = np.array([work.maximize(unit(angle) @ position(0, 2)).point for angle in np.linspace(-3, 3, 9)])
    pulled = program.pulled(points, deepest.point)
    held = program.holds(pulled)
    assert held.all()
    assert all(feasible(program, point) for point in pulled)


@pytest.mark.parametrize("name", ["plain", "extreme", "coarse"])
def test_pruning_never_shrinks(name):
    world = World(np.random.default_rng(0), **WORLDS[name])
    *_, belief = run(world, rows_per_robot=MANY, rows_per_pair=MANY)
    polytope = belief.polytope
    pruned = polytope.with_constraints(prune(polytope, 5, 5))
    assert len(pruned.constraints) < len(polytope.constraints)
    for robot in range(len(polytope.lower)):
        before, after = (exact_projection(which, robot) for which in (polytope, pruned))
        assert (supports(after) >= supports(before) - SAME).all()
        assert of_robot(pruned, robot)[0].area >= of_robot(polytope, robot)[0].area - 1e-12


def exact_projection(polytope, robot):
    program = polytope.program()
    D = position(robot, len(polytope.lower))
    return project(program, workspace(program, "highs"), D, deepest_point(program, "highs").point, stop=TIGHT).outer


@pytest.mark.parametrize("seed", range(4))
def test_another_constraint_never_grows_the_exact_set(seed):
    world = World(np.random.default_rng(seed), robots=3)
    *_, belief = run(world, steps=1, cells=0)
    rows = belief.constraints
    fewer = belief.polytope.with_constraints(rows.select(np.arange(len(rows)) % 3 != 0))
    for robot in range(3):
        assert (supports(exact_projection(belief.polytope, robot)) <= supports(exact_projection(fewer, robot)) + SAME).all()


@pytest.mark.parametrize("seed", range(4))
def test_another_bearing_or_compass_never_grows_the_exact_set(seed):
    world = World(np.random.default_rng(seed), robots=3)
    compass, bearing, _ = world.measure()
    half = bearing_of(bearing, np.arange(len(bearing.robot)) % 2 == 0)
    estimator = SetMembershipFilter(world.team, stop=TIGHT, rows_per_robot=MANY, rows_per_pair=MANY, cells=0)
    start = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    before = None
    for records in ([], [half], [bearing, half], [compass, bearing, half]):
        now = [supports(region.outer) for region in estimator.update(start, records).regions]
        if before is not None:
            assert all((after <= earlier + SAME).all() for after, earlier in zip(now, before, strict=True))
        before = now


@pytest.mark.parametrize("seed", range(4))
def test_another_range_makes_no_region_larger_than_its_tangents_allow(seed):
    """Where the tangents of a range stand depends on what is known of its direction, hence not exactly never larger."""
    tangents = 1.024
    world = World(np.random.default_rng(seed), robots=3)
    compass, bearing, ranges = world.measure()
    estimator = SetMembershipFilter(world.team, stop=TIGHT, rows_per_robot=MANY, rows_per_pair=MANY, cells=0)
    start = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    before = None
    for records in ([ranges], [ranges, bearing], [ranges, bearing, compass]):
        now = [region.outer.area for region in estimator.update(start, records).regions]
        if before is not None:
            assert all(after <= tangents * earlier for after, earlier in zip(now, before, strict=True))
        before = now


def bearing_of(record, chosen):
    return Bearing(record.time, record.robot[chosen], record.target[chosen], record.bearing[chosen], record.bound[chosen])


def parts(record):
    """Return a record as one record for each of its measurements."""
    names = [column.name for column in dataclasses.fields(record) if column.name != "time"]
    return [
        type(record)(time=record.time, **{name: getattr(record, name)[k] for name in names}) for k in range(len(record.robot))
    ]


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_measurements_does_not_matter(seed):
    world = World(np.random.default_rng(seed), robots=3)
    records = [part for record in world.measure() for part in parts(record)]
    estimator = SetMembershipFilter(world.team, stop=TIGHT, rows_per_robot=MANY, rows_per_pair=MANY, cells=0)
    start = estimator.start(0.0, world.initial_sets(), world.initial_headings(1.5))
    expected = estimator.update(start, records)
    for _ in range(2):
        shuffled = estimator.update(start, [records[k] for k in world.rng.permutation(len(records))])
        for one, other in zip(expected.regions, shuffled.regions, strict=True):
            assert supports(other.outer) == pytest.approx(supports(one.outer), abs=SAME)
        assert shuffled.headings.bound == pytest.approx(expected.headings.bound, abs=1e-12)


def test_the_order_of_ranges_does_not_matter_where_directions_are_hardly_known():
    """Two ranges of one pair: what the first one says of the direction must not shape the second one's rows."""
    estimator = SetMembershipFilter(Team(2), stop=TIGHT)
    start = estimator.start(0.0, [Polygon.box([0, 0], [0.5, 0.4]), Polygon.box([1.4, -1.5], [3.9, 0.2])])
    records = [Range(0, 0, 1, 3.8, 0.2, 0), Range(0, 1, 0, 3.6, 0.3, 0)]
    one, other = estimator.update(start, records), estimator.update(start, records[::-1])
    for mine, theirs in zip(one.regions, other.regions, strict=True):
        assert supports(mine.outer) == pytest.approx(supports(theirs.outer), abs=SAME)


@pytest.mark.parametrize("move", [[1.0, -2.0], [1e3, 1e3]])
def test_moving_the_world_moves_the_result(move):
    def believed(by):
        world = World(np.random.default_rng(3), robots=3)
        records, motion = world.measure(), None
        sets, headings = world.initial_sets(), world.initial_headings()
        motion = world.move()
        later = world.measure()
        team = Team(3, world.team.landmarks + by, 0.5, 2.0)
        moved = [Polygon.box(one.bounds[0] + by, one.bounds[1] + by) for one in sets]
        estimator = SetMembershipFilter(team, stop=TIGHT, rows_per_robot=MANY, rows_per_pair=MANY, cells=0)
        belief = estimator.update(estimator.start(0.0, moved, headings), records)
        return estimator.update(estimator.predict(belief, motion.time, motion), later)

    here, there = believed(np.zeros(2)), believed(np.array(move))
    directions = unit(np.linspace(-np.pi, np.pi, 48, endpoint=False))
    for one, other in zip(here.regions, there.regions, strict=True):
        assert supports(other.outer) - directions @ move == pytest.approx(supports(one.outer), abs=10 * SAME)
        assert other.outer.area == pytest.approx(one.outer.area, rel=1e-4)


@pytest.mark.parametrize("angle", [np.pi / 2, np.pi, 1.0, -2.5])
def test_turning_the_world_turns_the_exact_set(angle):
    """Rows are turned by hand: boxes are along the axes, so that they have to be wide enough not to count."""
    rotation = np.array([unit(angle), unit(angle + np.pi / 2)]).T
    world = World(np.random.default_rng(4), robots=3)
    *_, belief = run(world, steps=1, cells=0)
    rows = belief.constraints
    lower, upper = np.full((3, 2), -100.0), np.full((3, 2), 100.0)
    sides = [
        on_robot(k, region.outer.normals, region.outer.offsets, np.zeros(len(region.outer.offsets), dtype=int))
        for k, region in enumerate(belief.regions)
    ]
    everything = Constraints.concatenate([rows, *sides])
    turned = Constraints(everything.i, everything.j, everything.normal @ rotation.T, everything.offset, everything.source)
    directions = unit(np.linspace(-np.pi, np.pi, 48, endpoint=False))
    for robot in range(3):
        before = exact_projection(Polytope(everything, lower, upper), robot)
        after = exact_projection(Polytope(turned, lower, upper), robot)
        assert after.support(directions @ rotation.T) == pytest.approx(before.support(directions), abs=10 * SAME)
        assert after.area == pytest.approx(before.area, rel=1e-4)


@pytest.mark.parametrize("angle", [np.pi / 2, 1.0, -2.5])
def test_turning_every_measurement_turns_the_regions(angle):
    """Where landmarks and a wide start determine everything, the box along the axes does not count."""
    rotation = np.array([unit(angle), unit(angle + np.pi / 2)]).T

    def believed(turn, matrix):
        world = World(np.random.default_rng(5), robots=3, landmarks=4, sight=99.0)
        compass, bearing, ranges = world.measure()
        team = Team(3, world.team.landmarks @ matrix.T)
        estimator = SetMembershipFilter(team, stop=TIGHT)
        start = estimator.start(0.0, [Polygon.box([-200, -200], [200, 200])] * 3)
        compass = Compass(0.0, compass.robot, compass.heading + turn, compass.bound)
        belief = estimator.update(start, [compass, bearing])  # first, so that directions of ranges are known
        return estimator.update(belief, [ranges])

    before, after = believed(0.0, np.eye(2)), believed(angle, rotation)
    for one, other in zip(before.regions, after.regions, strict=True):
        assert other.outer.area == pytest.approx(one.outer.area, rel=0.02)
        assert other.outer.centroid == pytest.approx(rotation @ one.outer.centroid, abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_renaming_robots_renames_the_regions(seed):
    order = np.array([2, 0, 3, 1])  # new number of each robot

    def believed(new):
        world = World(np.random.default_rng(seed), robots=4)
        compass, bearing, ranges = world.measure()
        name = np.append(new, 4)  # the landmark keeps its number
        back = np.argsort(new)
        sets, headings = world.initial_sets(), world.initial_headings()
        records = [
            Compass(0.0, name[compass.robot], compass.heading, compass.bound),
            Bearing(0.0, name[bearing.robot], name[bearing.target], bearing.bearing, bearing.bound),
            Range(0.0, name[ranges.robot], name[ranges.target], ranges.range, ranges.bound, ranges.relative_bound),
        ]
        estimator = SetMembershipFilter(world.team, stop=TIGHT, rows_per_robot=MANY, rows_per_pair=MANY, cells=0)
        start = estimator.start(0.0, [sets[k] for k in back], AngularIntervals(headings.centre[back], headings.bound[back]))
        belief = estimator.update(start, records)
        return [belief.regions[k] for k in new], belief.headings.bound[new]

    (regions, headings), (renamed, same_headings) = believed(np.arange(4)), believed(order)
    for one, other in zip(regions, renamed, strict=True):
        assert supports(other.outer) == pytest.approx(supports(one.outer), abs=10 * SAME)
    assert same_headings == pytest.approx(headings, abs=1e-12)


@pytest.mark.parametrize("options", [{}, {"exact": False}, {"exact": False, "solvers": ("highs",)}])
def test_the_same_seed_gives_bitwise_the_same(options):
    def bits():
        *_, belief = run(World(np.random.default_rng(6), robots=3), steps=2, **options)
        arrays = [belief.constraints.normal, belief.constraints.offset, belief.headings.centre, belief.headings.bound]
        return [array.tobytes() for array in arrays] + [region.outer.vertices.tobytes() for region in belief.regions]

    assert bits() == bits()


def test_a_broken_bound_does_not_go_unnoticed_for_long():
    """Sound, but not by saying nothing: a range that lies by half is proved wrong."""
    world = World(np.random.default_rng(7), robots=3)
    *_, belief = run(world)
    estimator = SetMembershipFilter(world.team)
    ranges = world.measure()[-1]
    lie = Range(ranges.time, ranges.robot, ranges.target, 0.5 * ranges.range, ranges.bound, ranges.relative_bound)
    with pytest.raises(Inconsistent):
        estimator.update(belief, [lie])


def test_regions_are_small_and_not_only_sound():
    world = World(np.random.default_rng(8), robots=4)
    *_, belief = run(world, steps=8)
    assert max(region.outer.area for region in belief.regions) < 0.1
    assert (belief.headings.bound < world.compass + 1e-6).all()
