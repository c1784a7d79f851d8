"""What a filter names when things exclude one another: they do by themselves, none is too many, and the guilty one is there."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from helpers.cells import nowhere
from helpers.faults import ARENA, AT_ONCE, DEGREE, LANDMARKS, LATER, Faulty, conflicting, conflicting_later, key_of
from helpers.teams import snapshot
from helpers.worlds import World

from filter import (
    AngularIntervals,
    Bearing,
    Compass,
    Inconsistent,
    Odometry,
    Polygon,
    Range,
    SetMembershipFilter,
    Source,
    Team,
    Window,
)
from filter.sets import conflict, set_membership
from filter.sets.conflict import Part, Premises, conflict_of, minimal

SENSORS = [("compass", "bearing", "range"), ("compass", "range"), ("compass", "bearing"), ("range",), ("bearing",)]
LIGHT = {"pairs": 0, "corners": False, "rows_per_robot": 12, "rows_per_pair": 8}
OPTIONS = [{}, {}, LIGHT, {"scope": Window(hops=1)}, {"exact": False}]
DRAWS = {1: 8, 3: 4}  # for so many robots
TEAM = Team(1, LANDMARKS, 0.5, 1.5, ARENA)


def drawn(seed, fault, robots, later, **more):
    """Return conflicts in worlds with one fault each, large or small."""
    for draw in range(DRAWS[robots]):
        rng = np.random.default_rng([seed, draw, robots, later])
        sensors, options = (choices[int(rng.integers(len(choices)))] for choices in (SENSORS, OPTIONS))
        world = Faulty(rng, fault, robots, sensors, options | more, float(rng.uniform() ** 2))
        found = conflicting(world, int(rng.integers(1, 4)) if later else 0)
        if found is not None:
            yield found


@pytest.mark.parametrize("robots", [1, 3])
@pytest.mark.parametrize(("fault", "later"), [*((each, 0) for each in AT_ONCE), *((each, 1) for each in LATER)])
def test_what_is_named_is_a_conflict_by_itself_that_needs_each_of_them_and_has_the_guilty_one(fault, later, robots):
    found = list(drawn(1, fault, robots, later))
    assert len(found) >= DRAWS[robots] / 4
    for case in found:
        assert any(map(case.world.is_guilty, case.named)), case.named
        assert case.excluded(case.named), case.named
        time = case.named[-1].time
        arena = tuple(Source("arena", time, robot) for robot in range(robots))
        for source in case.named:
            fewer = tuple(other for other in case.named if other is not source)
            fewer += arena if source.kind != "arena" else ()  # taken for granted, if it is not what is left out
            assert not case.excluded(fewer), (source, case.named)


@pytest.mark.parametrize("fault", ["initial set", "heading", "odometry", "turn limit", "range", "bearing"])
def test_what_went_wrong_earlier_is_in_something_false_that_is_named(fault):
    seen = 0
    for draw in range(10):
        rng = np.random.default_rng([4, draw])
        sensors = SENSORS[int(rng.integers(len(SENSORS)))]
        case = conflicting_later(Faulty(rng, fault, 2, sensors, strength=float(rng.uniform())))
        if case is not None:
            seen += 1
            assert any(case.world.is_guilty(source) or case.is_false(source) for source in case.named), case.named
            assert case.excluded(case.named)
    assert seen >= 3


@pytest.mark.parametrize("robots", [1, 3])
@pytest.mark.parametrize(
    ("fault", "later"), [("initial set", 0), ("range", 0), ("range", 1), ("odometry", 1), ("speed limit", 1)]
)
def test_certificates_of_what_is_named_hold_without_any_rounding(fault, later, robots):
    gaps = [case.exact_gap(case.named) for case in drawn(2, fault, robots, later, cells=0)]
    proved = [gap for gap in gaps if gap is not None]  # the others are arcs of a heading that are apart
    assert len(proved) >= len(gaps) / 4
    assert all(gap < 0 for gap in proved)


@pytest.mark.parametrize("fault", AT_ONCE)
def test_no_place_in_the_plane_agrees_with_all_that_is_named(fault):
    """Cell by cell, without rows, solvers or sets."""
    for case in drawn(3, fault, 1, 0):
        kinds, held = {each.kind for each in case.named}, {(each.kind, each.robot, each.target) for each in case.named}
        low, high = ARENA if "arena" in kinds else (np.full(2, -100.0), np.full(2, 100.0))
        polygon = case.world.sets[0] if "initial set" in kinds else None
        headings = case.before.headings
        arc = (headings.centre[0], headings.bound[0]) if "heading" in kinds else None
        records = [record for record in case.records if key_of(record) in held]
        assert nowhere((low, high), polygon, arc, records, LANDMARKS), case.named


def test_where_the_truth_can_be_no_cell_is_left_out():
    """The guilty one left out, the rest is true; only few cells are tried then."""
    for case in drawn(3, "range", 1, 0):
        true = [record for record in case.records if key_of(record) != ("range", 0, case.world.about)]
        assert not nowhere(ARENA, case.world.sets[0], None, true, LANDMARKS, most=4000)


def started(polygon=None, heading=None, team=TEAM, **options):
    filter_ = SetMembershipFilter(team, **options)
    arcs = None if heading is None else AngularIntervals(*heading)
    return filter_, filter_.start(0.0, [polygon or Polygon.box([-2, -1], [0, 1])] * team.robots, arcs)


def named(filter_, belief, records):
    with pytest.raises(Inconsistent) as raised:
        filter_.update(belief, records)
    return raised.value.sources


def kinds(sources):
    return [source.kind for source in sources]


def test_a_start_beside_the_truth_is_named_although_all_measurements_agree():
    place, heading = np.array([-1.0, 0.0]), 0.2
    apart = LANDMARKS - place
    wrong = place + 1.3
    ranges = [Range(0.0, 0, k + 1, np.hypot(*apart[k]), 0.1, 0.0) for k in range(3)]
    bearings = [Bearing(0.0, 0, k + 1, np.arctan2(*apart[k][::-1]) - heading, 2 * DEGREE) for k in range(3)]
    compass = Compass(0.0, 0, heading, 2 * DEGREE)
    for records in ([compass, *ranges, *bearings], [compass, *ranges], [compass, *bearings]):
        filter_, belief = started(Polygon.box(wrong - 0.3, wrong + 0.3))
        assert kinds(named(filter_, belief, records))[0] == "initial set"
        assert len(filter_.update(filter_.start(0.0, [None]), records).events) == 0


def test_one_of_two_that_are_the_same_is_enough():
    filter_, belief = started()
    twice = [Range(0.0, [0, 0], [1, 1], [9.0, 9.0], 0.1, 0.0), Range(0.0, 0, 1, 9.0, 0.1, 0.0)]
    assert kinds(named(filter_, belief, twice)) == ["initial set", "range"]
    sources = named(filter_, belief, [Compass(0.0, [0, 0, 0], [1.0, 2.0, 2.0], 0.1)])
    assert sources == (Source("compass", 0.0, 0),) * 2


def test_what_just_touches_is_no_conflict_and_what_is_just_apart_is():
    filter_, belief = started(Polygon.box([0, -1e-3], [1, 1e-3]))
    touching = Range(0.0, 0, 1, 2.5, 0.5, 0.0)  # 3 m before the landmark at (4, 0)
    assert filter_.update(belief, [touching]).regions.outer.areas[0] >= 0
    for gap in (1e-3, 1e-5, 1e-6):
        assert kinds(named(filter_, belief, [replace(touching, range=[2.5 - gap])])) == ["initial set", "range"]
    filter_, belief = started(heading=([3.1], [0.1]))
    for sign, shown in ((1, 3.1 + 0.1 + 0.05), (-1, 3.1 - 0.1 - 0.05)):
        filter_.update(belief, [Compass(0.0, 0, shown - sign * 1e-9, 0.05)])
        assert kinds(named(filter_, belief, [Compass(0.0, 0, shown + sign * 1e-9, 0.05)])) == ["heading", "compass"]


def test_headings_and_directions_that_wrap_around():
    filter_ = SetMembershipFilter(Team(1, [[-4.0, 0.0]], arena=ARENA))
    belief = filter_.start(0.0, [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals([np.pi], [0.05]))
    filter_.update(belief, [Bearing(0.0, 0, 1, 2 * np.pi, 0.01), Compass(0.0, 0, -np.pi, 0.01)])
    sources = named(filter_, belief, [Bearing(0.0, 0, 1, np.pi - 0.01, 0.01), Compass(0.0, 0, -np.pi, 0.01)])
    assert kinds(sources) == ["initial set", "heading", "bearing"]
    assert kinds(named(filter_, belief, [Compass(0.0, 0, -np.pi + 0.2, 0.01)])) == ["heading", "compass"]


def test_records_without_a_measurement_and_robots_without_a_target():
    filter_, belief = started()
    none = np.zeros(0, dtype=int)
    empty = [Bearing(0.0, none, none, [], []), Range(0.0, none, none, [], [], []), Compass(0.0, none, [], [])]
    lie = Range(0.0, 0, 1, 9.0, 0.1, 0.0)
    assert named(filter_, belief, [*empty, lie, *empty]) == named(filter_, belief, [lie])
    blind = Team(1, arena=ARENA)
    filter_, belief = started(heading=([0.0], [0.1]), team=blind)
    assert kinds(named(filter_, belief, [*empty, Compass(0.0, 0, 1.0, 0.1)])) == ["heading", "compass"]


def test_three_robots_in_a_chain_and_nobody_besides():
    """Robot 0 is here, 2 is there, and what 1 measures to both is too short: robot 3 has nothing to do with it."""
    filter_ = SetMembershipFilter(Team(4, arena=ARENA))
    sets = [Polygon.box([-5, 0], [-4, 1]), None, Polygon.box([4, 0], [5, 1]), Polygon.box([0, 3], [1, 4])]
    records = [Range(0.0, [1, 1, 1], [0, 2, 3], [3.0, 3.0, 4.0], 0.5, 0.0), Range(0.0, 3, 0, 5.6, 1.0, 0.0)]
    sources = named(filter_, filter_.start(0.0, sets), records)
    assert [(source.kind, source.robot, source.target) for source in sources] == [
        ("initial set", 0, None),
        ("initial set", 2, None),
        ("range", 1, 0),
        ("range", 1, 2),
    ]


def test_what_is_known_of_a_pair_is_named():
    """It is hardly known where the two are, but how far apart: they stand still, and later are measured elsewhere."""
    team = Team(2, speed_limit=0.0, turn_rate_limit=0.0, arena=ARENA)
    filter_ = SetMembershipFilter(team)
    belief = filter_.start(0.0, [Polygon.box([-5, -2], [-1, 2]), Polygon.box([1, -2], [5, 2])])
    seen = [Compass(0.0, 0, 0.0, 0.01), Bearing(0.0, 0, 1, 0.0, 0.01), Range(0.0, 0, 1, 3.0, 0.1, 0.0)]
    later = filter_.predict(filter_.update(belief, seen), 1.0)
    sources = named(filter_, later, [Range(1.0, 1, 0, 5.0, 0.1, 0.0)])
    assert sources == (
        Source("pair", 0.0, 0, 1),
        Source("speed limit", 1.0, 0),
        Source("speed limit", 1.0, 1),
        Source("range", 1.0, 1, 0),
    )


def driven(time=1.0, distance=0.0, turn=0.0):
    return Odometry(0.0, time, 0, distance, 0.01, turn, 0.01, 0.0, 0.01)


def test_a_robot_that_has_left_the_arena_is_told_by_its_start_its_motion_and_the_arena():
    filter_, belief = started(heading=(0.0, 0.1))
    # From 20 m on it has left whatever its start.
    for distance, told in ((9.0, ["initial set", "heading", "arena", "odometry"]), (20.0, ["heading", "arena", "odometry"])):
        with pytest.raises(Inconsistent, match="robot 0 has left the arena") as raised:
            filter_.predict(belief, 1.0, driven(distance=distance))
        assert kinds(raised.value.sources) == told


def test_the_arena_is_named_only_where_it_is_needed():
    far = np.array([[20.0, 0.0]])
    outside = Range(0.0, 0, 1, 5.0, 0.1, 0.0)
    assert kinds(named(*started(team=Team(1, far, arena=ARENA)), [outside])) == ["arena", "range"]
    half_open = [[-6.0, -np.inf], [6.0, np.inf]]
    assert kinds(named(*started(team=Team(1, far, arena=half_open)), [outside])) == ["arena", "range"]
    assert kinds(named(*started(team=Team(1, far)), [outside])) == ["initial set", "range"]
    assert kinds(named(*started(team=Team(1, far, arena=3 * ARENA)), [outside])) == ["initial set", "range"]


def test_only_the_last_motion_is_kept_and_that_until_the_update():
    filter_, belief = started()
    for step in range(1, 6):
        belief = filter_.predict(belief, float(step))
        assert belief.moved.before.moved is None
        assert belief.moved.before.time == step - 1
    assert filter_.update(belief).moved is None


def test_a_prediction_that_was_changed_by_hand_is_named_by_what_is_there():
    """What it was made from does not explain the conflict any more."""
    filter_, belief = started()
    predicted = filter_.predict(belief, 1.0)
    moved = replace(predicted, polytope=filter_.start(1.0, [Polygon.box([2, 2], [3, 3])]).polytope)
    sources = named(filter_, moved, [Range(1.0, 0, 2, 5.0, 0.1, 0.0)])
    assert sources == (Source("region", 1.0, 0), Source("range", 1.0, 0, 2))


@pytest.mark.parametrize("origin", [0.0, 5e6])
def test_far_from_the_origin_it_is_the_same(origin):
    team = Team(1, LANDMARKS + origin, 0.5, 1.5, ARENA + origin)
    place = np.array([-1.0, 0.0]) + origin
    filter_, belief = started(Polygon.box(place - 0.3, place + 0.3), team=team)
    assert kinds(named(filter_, belief, [Range(0.0, 0, 1, 6.0, 0.1, 0.0)])) == ["initial set", "range"]
    both = [Range(0.0, [0, 0, 0], [1, 2, 3], [5.0, 2.0, 3.0], 0.1, 0.0)]
    assert set(kinds(named(filter_, filter_.start(0.0, [None]), both))) == {"range"}


def test_a_conflict_leaves_the_belief_as_it_was():
    filter_, belief = started()
    predicted = filter_.predict(belief, 1.0)
    before = snapshot(predicted)
    named(filter_, predicted, [Range(1.0, 0, 1, 9.0, 0.1, 0.0)])
    assert snapshot(predicted) == before


def test_without_a_conflict_nothing_is_taken_apart(monkeypatch):
    asked = Counter()
    for module, name in ((set_membership, "conflict_of"), (conflict.Premises, "exclude"), (conflict, "single")):
        monkeypatch.setattr(module, name, lambda *_, name=name: asked.update([name]))
    world = World(np.random.default_rng(0), robots=3)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(3):
        belief = filter_.update(filter_.predict(belief, motion.time, motion), records)
    assert not asked


def parts(count):
    return tuple(Part(Source("range", 0.0, 0, k), (0, k)) for k in range(count))


@pytest.mark.parametrize("seed", range(20))
def test_of_many_conflicts_one_is_found_and_the_first_parts_are_preferred(seed):
    rng, every = np.random.default_rng(seed), parts(24)
    conflicts = [frozenset(rng.permutation(24)[: rng.integers(1, 6)].tolist()) for _ in range(rng.integers(1, 4))]
    tests = []

    def exclude(some):
        tests.append(some)
        return any(each <= {part.reading[1] for part in some} for each in conflicts)

    found = frozenset(part.reading[1] for part in minimal(exclude, (), every))
    assert found in conflicts
    # The one whose last part comes first, and if that is the same, the last but one, ...
    least = [each for each in conflicts if not any(other < each for other in conflicts)]
    assert sorted(found, reverse=True) == min(sorted(each, reverse=True) for each in least)
    assert len(tests) <= 2 * len(found) * (np.log2(24 / len(found)) + 1) + 2 * len(found) + 4


def test_a_test_that_changes_its_mind_is_checked_once_more():
    every, asked = parts(8), Counter()

    def exclude(some):
        asked[some] += 1
        return len(some) in (3, 5, 8)

    found = minimal(exclude, (), every)
    assert exclude(found)


def test_what_cannot_be_proved_again_is_named_whole():
    _, belief = started(heading=(0.0, 0.1))
    records = (Range(0.0, 0, 1, 9.0, 0.1, 0.0),)
    premises = Premises(belief, None, records, TEAM, lambda *_: False)
    found = conflict_of(Inconsistent("at 0 s", []), [premises])
    assert kinds(found) == ["initial set", "heading", "range"]
