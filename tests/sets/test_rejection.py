"""When measurements disagree: which go, and that nothing goes silently."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.teams import BOX, TEAM, begun, estimator, odometry, snapshot, started
from helpers.worlds import World, escapes

from filter import Bearing, Compass, Range
from filter.errors import Inconsistent, InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.linear.sources import Source
from filter.projection.stop import never
from filter.sets.belief import Rejected
from filter.sets.conflict import Premises, conflict_of, single, without
from filter.sets.rejection import agreeing
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team


def rejecting(team=TEAM, **options):
    return estimator(team, policy="reject", **options)


def rejected(belief):
    return [event.source for event in belief.events if isinstance(event, Rejected)]


def world_and_belief(seed, **options):
    world = World(np.random.default_rng(seed), robots=4, sight=99.0, **options)
    return world, begun(rejecting(world.team), world)


def test_the_newest_of_two_that_exclude_one_another_goes():
    ranges = [Range(0, 0, 1, 1.2, 0.1, 0), Range(0, 1, 0, 2.9, 0.1, 0)]
    belief = rejecting().update(started(), ranges)
    (event,) = belief.events
    assert event.source == Source("range", 0.0, 1, 0)
    assert set(event.conflict) >= {Source("range", 0.0, 0, 1), Source("range", 0.0, 1, 0)}
    assert str(event).startswith("rejected range of robot 1 to 0 at 0.000 s; in conflict: ")
    alone = rejecting().update(started(), ranges[:1])
    assert [region.outer.area for region in belief.regions] == [region.outer.area for region in alone.regions]


def test_of_compasses_the_one_goes_that_the_others_contradict():
    shown = [Compass(0, 1, heading, bound) for heading, bound in [(1.0, 0.05), (0.0, 0.1), (0.02, 0.2), (-0.02, 0.3)]]
    belief = rejecting().update(started(), shown)
    (event,) = belief.events
    assert event.conflict[0].kind == event.conflict[1].kind == "compass"
    assert abs(belief.headings.centre[1]) < 0.1


def test_what_does_not_disagree_is_all_kept():
    world, belief = world_and_belief(0)
    records = world.measure()
    kept, raised = (each.update(belief, records) for each in (rejecting(world.team), estimator(world.team)))
    assert kept.events == ()
    assert snapshot(kept) == snapshot(raised)


@pytest.mark.parametrize("seed", range(4))
def test_one_wrong_range_is_dropped_alone(seed):
    world, belief = world_and_belief(seed)
    records = world.measure()
    wrong = int(world.rng.integers(len(records[-1].robot)))
    values = records[-1].range.copy()
    values[wrong] += 4.0
    records[-1] = replace(records[-1], range=values)
    after = rejecting(world.team).update(belief, records)
    assert len(rejected(after)) == 1
    robot, target = int(records[-1].robot[wrong]), int(records[-1].target[wrong])
    assert Source("range", 0.0, robot, target) in after.events[0].conflict


@pytest.mark.parametrize("seed", range(3))
def test_a_wrong_compass_is_one_measurement_not_many(seed):
    world, belief = world_and_belief(seed)
    belief = replace(belief, headings=AngularIntervals.circles(4))
    records = world.measure()
    shown = records[0].heading.copy()
    shown[2] += 1.0
    after = rejecting(world.team).update(belief, [replace(records[0], heading=shown), *records[1:]])
    assert rejected(after) == [Source("compass", 0.0, 2)]
    assert escapes(after, world.positions, world.headings) == []


def lying(world, lies):
    """Return records of which so many are false, and these as sources."""
    records, sources = world.measure(), []
    for _ in range(lies):
        k = int(world.rng.integers(len(records)))
        name = {Compass: "heading", Bearing: "bearing", Range: "range"}[type(records[k])]
        column, place = getattr(records[k], name).copy(), int(world.rng.integers(len(records[k].robot)))
        column[place] += 3.0 if name == "range" else 0.8
        records[k] = replace(records[k], **{name: column})
        sources.append(single(records)[k, place])
    return records, sources


@pytest.mark.parametrize("lies", [1, 2, 3])
@pytest.mark.parametrize("seed", range(6))
def test_no_more_are_dropped_than_are_false(seed, lies):
    """The false ones left out, the rest agrees: so the fewest are no more, and in each conflict there is a false one."""
    world, belief = world_and_belief(seed)
    records, false = lying(world, lies)
    after = rejecting(world.team).update(belief, records)
    assert len(rejected(after)) <= lies
    for event in (event for event in after.events if isinstance(event, Rejected)):
        assert event.source in event.conflict
        assert set(event.conflict) & set(false)


def test_a_conflict_is_looked_for_once(monkeypatch):
    """What hits no known conflict is not merged."""
    world, belief = world_and_belief(2)
    records, _ = lying(world, 3)
    merges, conflicts = [], []

    def found(*given):
        conflicts.append(conflict_of(*given))
        return conflicts[-1]

    def merge(kept):
        merges.append(kept)
        return estimator(world.team)._updated(belief, kept, never)

    monkeypatch.setattr("filter.sets.rejection.conflict_of", found)
    cases = [Premises(belief, None, tuple(records), world.team, estimator(world.team)._excludes)]
    agreeing(merge, tuple(records), cases)
    assert len(merges) == len(conflicts) + 1
    assert len({conflict.readings for conflict in conflicts}) == len(conflicts)


def test_where_only_the_start_and_the_motion_are_in_conflict_nothing_is_dropped():
    filter_ = rejecting(Team(1, [[9.0, 9.0]], 0.0, 0.0, [[0, 0], [4, 1]]))
    belief = filter_.start(0.0, [BOX], AngularIntervals([0.0], [0.1]))
    moved = filter_.predict(belief, 1.0, odometry(distance=2.0))
    apart = on_robot(0, np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, -1.5]), np.zeros(2, dtype=int))
    broken = replace(moved, moved=None, polytope=moved.polytope.with_constraints(apart))
    with pytest.raises(Inconsistent, match=r"to be dropped: .* all of: region of robot 0 at 1\.000 s$"):
        filter_.update(broken, [Range(1.0, 0, 1, 1.0, 0.1, 0.0), Compass(1.0, 0, 0.0, 0.1)])


@pytest.mark.parametrize("conflicts", [2, 64])
def test_where_very_much_is_wrong_none_goes_that_need_not(conflicts, monkeypatch):
    """A robot was carried away: all that is seen of it, and by it, contradicts where it can be."""
    monkeypatch.setattr("filter.sets.rejection.CONFLICTS", conflicts)
    world, belief = world_and_belief(1)
    world.positions[0] += 3.0
    records = world.measure()
    team_filter = rejecting(world.team)
    after = team_filter.update(belief, records)
    dropped = rejected(after)
    assert len(dropped) > 3
    numbers = [reading for reading, source in single(records).items() if source in dropped]
    for number in numbers[:: len(numbers) // 4]:
        with pytest.raises(Inconsistent):
            estimator(world.team).update(belief, without(records, dict.fromkeys([k for k in numbers if k != number], ())))


def test_without_a_measurement_in_the_conflict_there_is_nothing_to_drop():
    belief = started()
    way = np.array([[1.0, 0.0], [-1.0, 0.0]])
    apart = on_robot(0, way, np.array([0.4, -0.6]), belief.constraints.source[:2])
    contradictory = replace(belief, polytope=belief.polytope.with_constraints(apart))
    for records in ([], [Compass(0, 0, 0.0, 0.1), Range(0, 0, 1, 2.0, 1.0, 0)]):
        with pytest.raises(
            Inconsistent, match="no measurement of this update is in the conflict, to be dropped: no configuration"
        ):
            rejecting().update(contradictory, records)


def test_leaving_the_arena_is_never_mended_by_dropping():
    team = Team(1, arena=[[0, 0], [1, 1]])
    belief = rejecting(team).start(0.0, [BOX], AngularIntervals([0.0], [0.0]))
    with pytest.raises(Inconsistent, match="robot 0 has left the arena"):
        rejecting(team).predict(belief, 1.0, odometry(distance=2.0))


def test_readings_are_left_out_one_by_one():
    records = [Compass(0, [0, 1], [0.1, 0.2], 0.3), Bearing(0, [0, 0], [1, 2], [0.4, 0.5], 0.1), Range(0, 1, 0, 2.0, 0.1, 0)]
    assert [str(source)[:7] for source in single(records).values()] == ["compass", "compass", "bearing", "bearing", "range o"]
    left = without(records, {(0, 1): (), (1, 0): (), (2, 0): ()})
    assert left[0].heading.tolist() == [0.1]
    assert left[1].target.tolist() == [2]
    assert len(left) == 2


def test_an_unknown_policy_is_refused():
    with pytest.raises(InvalidInput, match="a policy among raise, reject; came 'ignore'"):
        SetMembershipFilter(TEAM, policy="ignore")
