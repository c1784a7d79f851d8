"""The filter's step: what it takes, what it refuses, and what it says when bounds are broken."""

import numpy as np
import pytest
from helpers.programs import supports
from helpers.teams import BOX, TEAM, beliefs, estimator, odometry, snapshot, started
from helpers.worlds import World, escapes, outside_hull

from filter import Bearing, Compass, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD
from filter.linear.sources import Source
from filter.projection.stop import Stop
from filter.projection.window import Window
from filter.team import Team

BAD_UPDATES = {
    "unknown robot": (lambda: [Compass(0, 2, 0, 0.1)], InvalidInput, "a robot among robots 0 to 1; came robot 2"),
    "unknown landmark": (lambda: [Bearing(0, 0, 3, 0, 0.1)], InvalidInput, "landmarks 2 to 2; came target 3"),
    "itself": (lambda: [Range(0, 1, 1, 1, 0.1, 0)], InvalidInput, "other than the robot that measures; came robot 1 on itself"),
    "late": (
        lambda: [Compass(-1, 0, 0, 0.1)],
        OutOfOrder,
        r"compass at -1\.0 s, but the belief is at 0\.0 s: it comes too late",
    ),
    "early": (lambda: [Range(1, 0, 1, 1, 0.1, 0)], OutOfOrder, r"range at 1\.0 s, .* predict to 1\.0 s first"),
    "no number": (lambda: [Bearing(0, 0, 1, np.nan, 0.1)], InvalidInput, r"bearing \[rad\]: finite numbers; came nan"),
    "infinite": (
        lambda: [Range(0, 0, 1, np.inf, 0.1, 0)],
        InvalidInput,
        r"range \[m\]: finite numbers within \[0, inf\]; came inf",
    ),
    "negative bound": (lambda: [Compass(0, 0, 0, -0.1)], InvalidInput, r"compass bound \[rad\]: .*; came -0\.1"),
    "wide bound": (lambda: [Bearing(0, 0, 1, 0, 4.0)], InvalidInput, r"bearing bound \[rad\]: .*; came 4\.0"),
    "good before bad": (lambda: [Compass(0, 0, 0, 0.1), Compass(0, 7, 0, 0.1)], InvalidInput, "came robot 7"),
    "motion": (
        lambda: [odometry(0, 0)],
        InvalidInput,
        "position or relative heading; came Odometry",
    ),
}


@pytest.mark.parametrize("name", BAD_UPDATES)
def test_a_bad_measurement_is_refused_and_the_belief_stays(name):
    records, error, message = BAD_UPDATES[name]
    belief = started()
    before = snapshot(belief)
    with pytest.raises(error, match=message):
        estimator().update(belief, records())
    assert snapshot(belief) == before


BAD_PREDICTIONS = {
    "backwards": (0.5, lambda: None, OutOfOrder, r"a prediction at 0\.5 s, but the belief is at 1\.0 s"),
    "no number": (np.nan, lambda: None, InvalidInput, r"time \[s\]: finite numbers; came nan"),
    "starts early": (
        2.0,
        lambda: odometry(0.5, 2.0),
        OutOfOrder,
        r"odometry that starts at 0\.5 s, but the belief is at 1\.0 s",
    ),
    "starts late": (2.0, lambda: odometry(1.5, 2.0), OutOfOrder, r"odometry that starts at 1\.5 s"),
    "ends elsewhere": (2.0, lambda: odometry(1.0, 3.0), InvalidInput, r"predicted time 2\.0 s; came 3\.0 s"),
    "unknown robot": (2.0, lambda: odometry(1.0, 2.0, robot=2), InvalidInput, "came robot 2"),
    "runs backwards": (2.0, lambda: odometry(2.0, 1.0), InvalidInput, "from 2.0 s on; came 1.0 s"),
    "negative bound": (2.0, lambda: odometry(1.0, 2.0, slip_bound=-1), InvalidInput, r"slip bound .*; came -1\.0"),
}


@pytest.mark.parametrize("name", BAD_PREDICTIONS)
def test_a_bad_motion_is_refused_and_the_belief_stays(name):
    time, motion, error, message = BAD_PREDICTIONS[name]
    belief = started(time=1.0)
    before = snapshot(belief)
    with pytest.raises(error, match=message):
        estimator().predict(belief, time, motion())
    assert snapshot(belief) == before


BAD_STARTS = {
    "too few sets": (lambda: {"positions": [BOX]}, "one initial polygon for each of 2 robots; came 1 polygons"),
    "too many sets": (lambda: {"positions": [BOX] * 3}, "came 3 polygons"),
    "empty set": (lambda: {"positions": [BOX, Polygon.box([1, 0], [0, 1])]}, "lower corner"),
    "no point": (lambda: {"positions": [BOX, Polygon.from_vertices(np.zeros((0, 2)))]}, "at least one point"),
    "outside": (lambda: {"positions": [BOX, Polygon.box([12, 0], [13, 1])]}, "r1 wholly outside"),
    "arcs": (lambda: {"headings": AngularIntervals.circles(3)}, "each of 2 headings, none empty; came 3 arcs"),
    "empty arc": (lambda: {"headings": AngularIntervals([0.0, 0.0], [0.1, -1.0])}, "none empty"),
    "no number": (lambda: {"headings": AngularIntervals([0.0, np.nan], [0.1, 0.1])}, "finite|number"),
    "no bound": (lambda: {"headings": AngularIntervals([0.0, 0.0], [0.1, np.nan])}, "finite|number"),
    "time": (lambda: {"time": np.nan}, r"time \[s\]: finite numbers; came nan"),
}


@pytest.mark.parametrize("name", BAD_STARTS)
def test_a_bad_start_is_refused(name):
    options, message = BAD_STARTS[name]
    team = Team(2, arena=[[-10, -10], [10, 10]])
    with pytest.raises(InvalidInput, match=message):
        estimator(team).start(**{"time": 0.0, "positions": [BOX, BOX], **options()})


def test_a_team_of_no_robots_is_refused():
    with pytest.raises(InvalidInput, match="number of robots: whole numbers from 1 to 1000000; came 0"):
        Team(0)


def test_an_unknown_solver_is_refused_with_those_installed():
    with pytest.raises(InvalidInput, match=r"a solver among .*highs.*piqp.*; came 'glpk'"):
        estimator(solvers=("piqp", "glpk"))


@pytest.mark.parametrize("name", ["rows_per_robot", "rows_per_pair"])
def test_a_budget_below_four_is_refused(name):
    with pytest.raises(InvalidInput, match=f"{name}: whole numbers from 4 on; came 3"):
        estimator(**{name: 3})


@pytest.mark.parametrize("wrong", [{"pairs": -1}, {"pairs": 1.5}, {"tangent_spacing": 0.0}, {"tangent_spacing": 2.0}])
def test_what_cannot_be_taken_along_is_refused(wrong):
    with pytest.raises(InvalidInput):
        estimator(**wrong)


def test_a_light_filter_is_light_but_for_what_is_asked():
    light = SetMembershipFilter.light(TEAM, pairs=3)
    assert (light.rows_per_robot, light.rows_per_pair, light.pairs) == (12, 8, 3)
    assert SetMembershipFilter.light(TEAM).pairs == 0
    assert SetMembershipFilter(TEAM).corners
    assert not SetMembershipFilter.light(TEAM).corners
    assert SetMembershipFilter.light(TEAM).cells < SetMembershipFilter(TEAM).cells


WAYS = {
    "walk": {},
    "walk alone": {"solvers": ()},
    "windows": {"scope": Window()},
    "piqp": {"exact": False, "solvers": ("piqp",)},
    "highs": {"exact": False, "solvers": ("highs",)},
}
BROKEN = {
    "two compasses": (
        lambda: [Compass(0, 1, 0.0, 0.1), Compass(0, 1, 1.0, 0.1)],
        {("compass", 1, None)},
    ),
    "a compass and the heading": (lambda: [Compass(0, 0, 1.0, 0.1)], {("compass", 0, None), ("heading", 0, None)}),
    "a bearing and the heading": (lambda: [Bearing(0, 0, 2, np.pi, 0.1)], {("bearing", 0, 2), ("heading", 0, None)}),
    "two ranges": (lambda: [Range(0, 0, 1, 1.2, 0.1, 0), Range(0, 1, 0, 2.9, 0.1, 0)], {("range", 0, 1), ("range", 1, 0)}),
    "a range and the sets": (lambda: [Range(0, 0, 2, 1.0, 0.1, 0)], {("range", 0, 2)}),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", BROKEN)
def test_what_excludes_one_another_is_inconsistent_and_named(name, way):
    records, named = BROKEN[name]
    belief = started(headings=AngularIntervals([0.0, 0.5], [0.3, np.pi]))
    before = snapshot(belief)
    with pytest.raises(Inconsistent) as raised:
        estimator(**WAYS[way]).update(belief, records())
    assert snapshot(belief) == before
    found = {(source.kind, source.robot, source.target) for source in raised.value.sources}
    assert named <= found
    assert all(str(source) in str(raised.value) for source in raised.value.sources)
    assert all(isinstance(source, Source) for source in raised.value.sources)


def test_measurements_are_not_blamed_that_have_nothing_to_do_with_it():
    team = Team(4)
    sets = [Polygon.box([3 * k, 0], [3 * k + 1, 1]) for k in range(4)]
    wrong = [Range(0, 2, 3, 8.0, 0.1, 0), Range(0, 0, 1, 3.0, 0.3, 0)]
    with pytest.raises(Inconsistent) as raised:
        estimator(team).update(started(team, sets), wrong)
    assert {(source.robot, source.target) for source in raised.value.sources if source.kind == "range"} == {(2, 3)}


def test_leaving_the_arena_is_inconsistent():
    team = Team(1, arena=[[0, 0], [1, 1]])
    belief = estimator(team).start(0.0, [BOX], AngularIntervals([0.0], [0.0]))
    with pytest.raises(Inconsistent, match="robot 0 has left the arena"):
        estimator(team).predict(belief, 1.0, odometry(distance=2.0))


def test_a_robot_stays_in_the_arena():
    team = Team(1, arena=[[0, 0], [1.5, 1.5]], speed_limit=1.0)
    belief = estimator(team).predict(estimator(team).start(0.0, [BOX]), 9.0)
    assert belief.regions[0].outer.area == pytest.approx(2.25)


def test_no_measurements_for_a_long_time_are_normal():
    world = World(np.random.default_rng(0), robots=3)
    belief = estimator(world.team).start(0.0, world.initial_sets(), world.initial_headings())
    for _ in range(30):
        belief = estimator(world.team).predict(belief, world.time + 0.1, world.move())
        if world.rng.random() < 0.3:
            belief = estimator(world.team).update(belief)
    assert escapes(belief, world.positions, world.headings) == []
    belief = estimator(world.team).predict(belief, 1e6)
    assert escapes(estimator(world.team).update(belief), world.positions) == []


def test_a_robot_that_nobody_sees_is_normal():
    world = World(np.random.default_rng(1), robots=4, sight=4.0)
    world.positions[3] += 100.0
    belief = estimator(world.team).start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(4):
        belief = estimator(world.team).update(estimator(world.team).predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []
    assert belief.regions[3].outer.area > max(region.outer.area for region in belief.regions[:3])


@pytest.mark.parametrize("landmarks", [0, 1])
def test_all_robots_in_one_point_are_normal(landmarks):
    world = World(np.random.default_rng(2), robots=4, landmarks=landmarks)
    world.positions[:] = world.positions[0]
    belief = estimator(world.team).start(0.0, world.initial_sets(), world.initial_headings())
    belief = estimator(world.team).update(belief, world.measure())
    assert escapes(belief, world.positions, world.headings) == []
    for motion, records in world.steps(3):
        belief = estimator(world.team).update(estimator(world.team).predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []


@pytest.mark.parametrize("landmarks", [0, 2])
def test_one_robot_alone_is_normal(landmarks):
    world = World(np.random.default_rng(3), robots=1, landmarks=landmarks)
    belief = estimator(world.team).start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(6):
        belief = estimator(world.team).update(estimator(world.team).predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []


def test_robots_on_one_line_are_normal():
    world = World(np.random.default_rng(4), robots=4)
    world.positions = np.stack([np.arange(4.0), np.zeros(4)], axis=1)
    world.headings[:] = 0.0
    belief = estimator(world.team).start(0.0, world.initial_sets(), world.initial_headings())
    assert escapes(estimator(world.team).update(belief, world.measure()), world.positions, world.headings) == []


def exact(world):
    """Return records without any error and with bounds of next to nothing."""
    world.bearing = world.range = world.compass = 0.0
    return world.measure()


@pytest.mark.parametrize("way", WAYS)
def test_bounds_of_zero_leave_next_to_a_point(way):
    world = World(np.random.default_rng(5), robots=3, landmarks=2, sight=99.0)
    team = estimator(world.team, **WAYS[way])
    belief = team.update(team.start(0.0, world.initial_sets(), world.initial_headings()), exact(world))
    assert escapes(belief, world.positions, world.headings) == []
    assert all(region.outer.area < 1e-8 for region in belief.regions)
    belief = team.update(belief, exact(world))
    assert escapes(belief, world.positions, world.headings) == []


@pytest.mark.parametrize("way", WAYS)
def test_a_wholly_known_team_stays_known(way):
    """Points as initial sets anchor every robot; exact measurements then say nothing new, and nothing wrong."""
    for seed in range(6):
        world = World(np.random.default_rng(seed), robots=3, sight=99.0)
        team = estimator(world.team, **WAYS[way])
        sets = [Polygon.box(position, position) for position in world.positions]
        belief = team.start(0.0, sets, AngularIntervals(world.headings, np.full(3, 1e-12)))
        belief = team.update(belief, exact(world))
        assert escapes(belief, world.positions) == []
        assert (belief.polytope.lower == belief.polytope.upper).all()
        motion = world.move()
        belief = team.update(team.predict(belief, motion.time, motion), exact(world))
        assert escapes(belief, world.positions) == []


@pytest.mark.parametrize("point", [Polygon.box, lambda lower, _: Polygon.from_vertices(lower[None])], ids=["box", "vertices"])
def test_one_anchored_robot_is_the_frame_of_the_others(point):
    world = World(np.random.default_rng(6), robots=3, landmarks=0, sight=99.0)
    sets = world.initial_sets(reach=2.0)
    sets[1] = point(world.positions[1], world.positions[1])
    team = estimator(world.team)
    belief = team.update(team.start(0.0, sets, world.initial_headings()), world.measure())
    assert escapes(belief, world.positions, world.headings) == []
    assert belief.polytope.upper[1] - belief.polytope.lower[1] == pytest.approx(0, abs=1e-12)
    assert max(region.outer.area for region in belief.regions) < 4.0


def test_bearings_alone_find_the_headings():
    """A team without any compass: two landmarks seen from a roughly known place say where forward is."""
    world = World(np.random.default_rng(7), robots=2, landmarks=3, sight=99.0)
    team = estimator(world.team)
    belief = team.start(0.0, world.initial_sets(reach=0.2))
    assert belief.headings.full.all()
    belief = team.update(belief, world.measure(compasses=False))
    assert escapes(belief, world.positions, world.headings) == []
    assert (belief.headings.bound < 0.5).all()


def test_no_records_and_empty_records_are_normal():
    belief = started()
    nothing = [Compass(0, [], [], []), Bearing(0, [], [], [], []), Range(0, [], [], [], [], [])]
    one, other = estimator().update(belief), estimator().update(belief, nothing)
    assert (
        [region.outer.area for region in one.regions]
        == [region.outer.area for region in other.regions]
        == pytest.approx([1, 1])
    )
    still = estimator().predict(belief, 0.0)
    assert [region.outer.area for region in still.regions] == pytest.approx([1, 1])


def test_every_error_of_a_filter_is_one_of_ours():
    with pytest.raises(CorralError):
        estimator().update(started(), [Compass(5, 0, 0, 0.1)])


def test_causes_name_the_measurement_that_made_an_edge():
    team = Team(1, landmarks=[[3.0, 0.5]])
    belief = estimator(team).update(started(team, [BOX]), [Range(0, 0, 1, 2.2, 0.1, 0)])
    sources = {str(source) for edge in range(len(belief.regions[0].causes)) for source in belief.causes(0, edge)}
    assert "range of robot 0 to 1 at 0.000 s" in sources


def test_the_search_stops_where_it_was_told():
    world = World(np.random.default_rng(8), robots=3)
    for stop in (Stop(searches=4), Stop(performance_ratio=0.7), Stop(performance_ratio=0.99, searches=60)):
        team = estimator(world.team, exact=False, stop=stop)
        belief = team.update(team.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
        for region in belief.regions:
            assert region.searches <= stop.searches
            assert region.reason == "searches" or region.performance_ratio >= stop.performance_ratio - 1e-4


def rows_on(belief):
    """Return how many rows there are on each robot and on each pair that has any."""
    i, j, first = belief.constraints.grouped()
    return dict(zip(zip(i.tolist(), j.tolist(), strict=True), np.diff(first).tolist(), strict=True))


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 4)])
@pytest.mark.parametrize("light", [False, True])
@pytest.mark.parametrize("budgets", [{}, {"rows_per_robot": 6, "rows_per_pair": 4}])
def test_the_budgets_bound_what_a_belief_carries(scope, light, budgets):
    world = World(np.random.default_rng(3), robots=5, landmarks=3, sight=99.0)
    team = (SetMembershipFilter.light if light else SetMembershipFilter)(world.team, scope=scope, **budgets)
    for belief in beliefs(team, world, 4):
        counts = rows_on(belief)
        assert max(count for (i, _), count in counts.items() if i == WORLD) <= team.rows_per_robot
        assert max(count for (i, _), count in counts.items() if i != WORLD) <= team.rows_per_pair
        assert len(belief.constraints) <= 5 * team.rows_per_robot + 10 * team.rows_per_pair
    assert len(belief.constraints) == sum(counts.values())


def test_a_prediction_adds_rows_that_the_next_update_prunes():
    world = World(np.random.default_rng(3), robots=4)
    team = estimator(world.team)
    *_, belief = beliefs(team, world, 2)
    motion = world.move()
    predicted = team.predict(belief, motion.time, motion)
    assert len(belief.constraints) < len(predicted.constraints) <= len(belief.constraints) + 8 * 4 + 16 * 6
    assert max(rows_on(team.update(predicted)).values()) <= team.rows_per_robot


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 3)])
@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
def test_where_one_is_as_seen_from_another_contains_the_truth_either_way_about(scope, errors, origin):
    world = World(np.random.default_rng(5), robots=4, errors=errors, origin=np.full(2, origin))
    team = estimator(world.team, scope=scope)
    i, j = np.array([0, 3, 2, 1, 0]), np.array([3, 0, 1, 2, 1])
    for belief in beliefs(team, world, 2):
        seen, back = team.relative(belief, i, j), team.relative(belief, j, i)
        apart = world.positions[j] - world.positions[i]
        rounding = 4e-16 * origin
        for k in range(5):
            assert (seen[k].normals @ apart[k] <= seen[k].offsets + rounding).all()
            assert not rounding or not outside_hull(seen[k], apart[k])
            assert back[k].normals.tolist() == (-seen[k].normals).tolist()
            assert back[k].offsets.tolist() == seen[k].offsets.tolist()
            assert back[k].vertices.tolist() == (-seen[k].vertices).tolist()
            assert back[k].area > 0
        assert seen[0].vertices.tolist() == (-seen[1].vertices).tolist()
    if scope.leaves_nobody_out and not origin:
        for k in range(5):
            true = supports(belief.polytope, seen[k].normals, int(j[k]), int(i[k]))
            assert (seen[k].offsets >= true - 1e-9).all()
            assert seen[k].support(seen[k].normals) == pytest.approx(true, rel=1e-2, abs=1e-2)


@pytest.mark.parametrize(
    "wrong", [([0], [0]), ([0], [2]), ([-1], [0]), ([0, 1], [1]), (0, 1), ([0.5], [1]), ([0], [10**9]), ([[0]], [[1]])]
)
def test_pairs_that_are_none_are_refused(wrong):
    belief = started()
    with pytest.raises(InvalidInput):
        estimator().relative(belief, *map(np.array, wrong))


def test_of_no_pairs_nothing_is_said():
    none = np.zeros(0, dtype=int)
    assert len(estimator().relative(started(), none, none)) == 0


def test_phases_are_told_in_their_order():
    told = []
    team = estimator(on_phase=told.append)
    team.predict(team.update(started()), 1.0)
    assert told[-1] == "predict"
    assert list(dict.fromkeys(told[:-1])) == ["headings", "merge", "prune", "project", "forget"]
