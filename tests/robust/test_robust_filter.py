"""The robust filter: the truth stays inside while the declared bounds hold, and while some votes are lies."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.robust_worlds import ARENA, missing, started, world_of

from filter import Bearing, Compass, Odometry, Range
from filter.errors import InvalidInput, OutOfOrder
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.robust.belief import Disagreement, Distrusted, Rejected, Restarted
from filter.robust.hypotheses import AGREED
from filter.robust.robust_filter import RobustFilter
from filter.robust.votes import Rules
from filter.team import Team


def stays_in_the_arena(world):
    lower, upper = np.array(ARENA)
    return (world.positions > lower).all() and (world.positions < upper).all()


def follow(robust, world, belief, count=25, lie=None):
    """Yield the belief at each step of a world that measures without compasses, its records changed by `lie`."""
    for step in range(count):
        motion = world.move(0.4)
        if not stays_in_the_arena(world):
            return
        belief, records = robust.predict(belief, world.time, motion), world.measure(compasses=False)
        belief = robust.update(belief, lie(step, records) if lie else records)
        yield belief


def lying(robot, target, turn=1.0, more=1.5):
    """Return what makes all sightings of one pair wrong by so much [rad], [m]."""

    def lied(record):
        wrong = (record.robot == robot) & (record.target == target)
        if isinstance(record, Bearing):
            return replace(record, bearing=record.bearing + np.where(wrong, turn, 0.0))
        return replace(record, range=record.range + np.where(wrong, more, 0.0))

    return lambda records: [lied(record) for record in records]


def figures(belief):
    columns = [(known.without, known.low, known.high, known.reach) for known in belief.sets]
    return [column.tobytes() for set_ in columns for column in set_]


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("known", ["pose", "position", "arena"])
@pytest.mark.parametrize("seed", range(3))
def test_the_truth_stays_inside_while_bounds_hold(seed, known, errors):
    world = world_of(seed, errors=errors)
    robust = RobustFilter(world.team)
    for belief in follow(robust, world, started(robust, world, known)):
        assert missing(belief, world) == []
        assert belief.events == ()
        assert belief.guarantee.in_force.all()


@pytest.mark.parametrize("known", ["position", "arena"])
def test_unknown_headings_and_positions_are_found(known):
    world = world_of(1, landmarks=8)
    robust = RobustFilter(world.team)
    belief = list(follow(robust, world, started(robust, world, known)))[-1]
    assert max(region.outer.area for region in belief.regions) < 2.0
    assert belief.headings.bound.max() < 0.5


@pytest.mark.parametrize("seed", range(6))
def test_one_lie_in_a_window_does_no_harm(seed):
    """Whatever a vote says, near or far from the truth, for as long as a vote lasts."""
    world, rng = world_of(seed), np.random.default_rng(seed + 100)
    robust = RobustFilter(world.team, Rules(window=4.0, longest=2.0))
    robot, target = rng.integers(3), rng.integers(3, 8)
    wrong = lying(robot, target, rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6))
    lie = lambda step, records: wrong(records) if step % 20 in (9, 10) else records  # noqa: E731
    for belief in follow(robust, world, started(robust, world), 30, lie):
        assert missing(belief, world) == []


@pytest.mark.parametrize("seed", range(3))
def test_a_wrong_barcode_is_rejected_and_named(seed):
    world = world_of(seed, landmarks=6, size=3.0)
    robust = RobustFilter(world.team)
    wrong, events = lying(1, 5, np.pi), []
    for belief in follow(
        robust, world, started(robust, world), 12, lambda step, records: wrong(records) if step == 8 else records
    ):
        events += belief.events
        assert missing(belief, world) == []
    (event,) = events
    assert isinstance(event, Rejected)
    assert (event.source.robot, event.source.target) == (1, 5)
    assert "rejected sighting of robot 1 to 5" in str(event)


def test_a_tolerated_lie_costs_area_and_nothing_else():
    areas = []
    for tolerated in (0, 1):
        world = world_of(2)
        robust = RobustFilter(world.team, Rules(tolerated=tolerated))
        belief = list(follow(robust, world, started(robust, world)))[-1]
        areas.append([region.outer.area for region in belief.regions])
        if not tolerated:
            assert all((known.without == AGREED).all() for known in belief.sets)
    assert (np.array(areas[0]) <= np.array(areas[1]) + 1e-9).all()


def test_contradictory_votes_are_both_suspects_and_the_truth_survives():
    robust = RobustFilter(Team(1, [[2.0, 0.0], [0.0, 2.0]], arena=ARENA))
    belief = robust.start(0.0, [Polygon.box([-1, -1], [1, 1])], AngularIntervals([0.0], [0.1]))
    lie = [Range(0.0, 0, 1, 2.5, 0.1, 0.0), Bearing(0.0, 0, 1, 0.0, 0.1)]  # it is at (0, 0): 0.5 m too far, and not yet noticed
    belief = robust.update(belief, lie)
    assert belief.events == ()
    belief = robust.update(belief, [Range(0.0, 0, 2, 2.0, 0.1, 0.0), Bearing(0.0, 0, 2, np.pi / 2, 0.05)])
    assert belief.regions[0].outer.contains([0.0, 0.0])
    belief = robust.update(belief, [Compass(0.0, [0], [0.0], 0.05)])
    assert belief.regions[0].outer.contains([0.0, 0.0])
    told = robust.update(belief, [Range(0.0, 0, 1, 1.2, 0.1, 0.0)])  # another lie, of the same pair
    assert told.regions[0].outer.contains([0.0, 0.0])
    assert all(isinstance(event, Disagreement | Rejected) for event in told.events)


def test_order_within_an_instant_makes_no_difference():
    world = world_of(4)
    robust = RobustFilter(world.team)
    belief = robust.predict(started(robust, world), 0.4, world.move(0.4))
    records = world.measure(compasses=True)
    split = [replace(r, **{n: getattr(r, n)[k : k + 1] for n in names(r)}) for r in records for k in range(len(r.robot))]
    rng = np.random.default_rng(0)
    once = figures(robust.update(belief, records))
    for _ in range(3):
        assert figures(robust.update(belief, [split[k] for k in rng.permutation(len(split))])) == once


def names(record):
    return [name for name in vars(record) if name != "time"]


def test_a_world_turned_by_a_quarter_gives_regions_turned_by_a_quarter():
    world, areas = world_of(5), []
    beliefs = {}
    motion, records = world.move(0.4), world.measure(compasses=False)
    for turned in (False, True):
        marks = world.team.landmarks @ np.array([[0.0, 1.0], [-1.0, 0.0]]) if turned else world.team.landmarks
        robust = RobustFilter(Team(3, marks))
        corners = [[-9.0, -3.0], [3.0, 9.0]] if turned else ARENA
        belief = robust.start(0.0, [Polygon.box(*corners)] * 3)
        beliefs[turned] = robust.update(robust.predict(belief, 0.4, motion), records)
        areas.append([region.outer.area for region in beliefs[turned].regions])
    np.testing.assert_allclose(areas[0], areas[1], rtol=1e-6)
    np.testing.assert_allclose(beliefs[False].headings.bound, beliefs[True].headings.bound, atol=1e-6)


def test_a_robot_that_was_taken_elsewhere_starts_over():
    world = world_of(7, robots=1, landmarks=8, size=4.0)
    robust = RobustFilter(world.team)
    belief = list(follow(robust, world, started(robust, world), 10))[-1]
    world.positions = 2.0 + 0.0 * world.positions
    world.headings = wrap(world.headings + 2.5)
    after = list(follow(robust, world, belief, 20))
    belief = after[-1]
    (restart,) = [event for each in after for event in each.events if isinstance(event, Restarted)]
    assert restart.robot == 0
    assert restart.suspended_since <= restart.time <= belief.time
    assert "starts over" in str(restart)
    assert missing(belief, world) == []
    assert belief.guarantee.in_force[0]


@pytest.mark.parametrize("seed", range(2))
def test_one_bad_first_picture_costs_a_few_steps(seed):
    world = world_of(seed, robots=1, landmarks=4, size=4.0)
    robust = RobustFilter(world.team)

    def turned(step, records):
        return [
            replace(each, bearing=each.bearing + 0.5) if isinstance(each, Bearing) and not step else each for each in records
        ]

    beliefs = list(follow(robust, world, started(robust, world), 12, turned))
    assert not beliefs[-1].trust.camera.any()
    assert missing(beliefs[-1], world) == []
    assert max(belief.regions[0].outer.area for belief in beliefs[5:]) < 1.0


def test_an_identity_that_is_always_wrong_is_put_aside_and_named():
    """Landmark 0 hangs elsewhere than declared, metres away."""
    world = world_of(8, robots=3, landmarks=8, size=4.0)
    declared = world.team.landmarks.copy()
    declared[0] += [5.0, 2.0]
    robust = RobustFilter(replace(world.team, landmarks=declared))
    after = list(follow(robust, world, started(robust, world), 30))
    belief = after[-1]
    named = [event for each in after for event in each.events if isinstance(event, Distrusted)]
    assert [(event.sensor, event.body, event.aside) for event in named] == [("identity", 3, True)]
    assert "identity of landmark 3 put aside" in str(named[0])
    assert belief.trust.aside(0, 3)
    assert missing(belief, world) == []


def test_without_odometry_a_robot_may_go_anywhere_within_its_limits():
    robust = RobustFilter(Team(2, speed_limit=0.5, turn_rate_limit=0.1))
    belief = robust.start(0.0, [Polygon.box([0, 0], [0, 0])] * 2, AngularIntervals([3.1, 0.0], [0.0, 0.0]))
    still = Odometry(0.0, 1.0, [0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    moved = robust.predict(belief, 1.0, still)
    assert moved.regions[0].outer.area < 1e-9
    assert moved.regions[1].outer.support([[1.0, 0.0]])[0] == pytest.approx(0.5)
    assert moved.headings.bound[1] == pytest.approx(0.1)


def test_a_belief_goes_in_and_stays_as_it_was():
    world = world_of(9)
    robust = RobustFilter(world.team)
    belief = started(robust, world)
    before = figures(belief)
    after = robust.update(robust.predict(belief, 0.4, world.move(0.4)), world.measure())
    assert figures(belief) == before != figures(after)
    with pytest.raises(ValueError, match="read-only"):
        after.sets[0].reach[0] = 0.0


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        (lambda f: f.start(0.0, [Polygon.box([0, 0], [1, 1])]), InvalidInput),
        (lambda f: f.start(0.0, [Polygon.box([0, 0], [1, 1])] * 2, AngularIntervals([0.0], [0.1])), InvalidInput),
        (lambda f: f.update(begun(f), [Range(1.0, 0, 1, 1.0, 0.1, 0.0)]), OutOfOrder),
        (lambda f: f.update(begun(f), [Range(0.0, 0, 7, 1.0, 0.1, 0.0)]), InvalidInput),
        (lambda f: f.predict(begun(f), -1.0), OutOfOrder),
        (lambda f: RobustFilter(f.team, cells=4), InvalidInput),
        (lambda f: Rules(tolerated=2), InvalidInput),
        (lambda f: Rules(window=-1.0), InvalidInput),
    ],
)
def test_bad_input_is_refused(wrong, error):
    robust = RobustFilter(Team(2))
    with pytest.raises(error):
        wrong(robust)


def begun(robust):
    return robust.start(0.0, [Polygon.box([0, 0], [1, 1])] * 2)


@pytest.mark.parametrize("where", ["arena", "landmark", "start"])
def test_places_that_are_too_far_from_the_origin_are_refused(where):
    far, near = np.array([5e5, 5.4e6]), np.zeros(2)
    arena = np.array([far - 10, far + 10]) if where == "arena" else np.array([[-np.inf] * 2, [np.inf] * 2])
    mark, place = (far if where == name else near for name in ("landmark", "start"))
    with pytest.raises(InvalidInput, match="subtract"):
        RobustFilter(Team(1, [mark + 3], arena=arena)).start(0.0, [Polygon.box(place - 1, place + 1)])
