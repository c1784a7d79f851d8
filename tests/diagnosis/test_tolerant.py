"""A tolerance: while no more lie than it says, the truth is inside, in each case and in what holds in all of them."""

import pickle
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.drawn.broken import drawn, followed, going_on, outside, stepped
from helpers.drawn.lies import lied, one_liar_a_window
from helpers.drawn.tolerant import WINDOW, followed_in, known, light, suspects_in, tolerant

from experiments.beacons.scenes import DRIVES, alone, team_that_stands
from filter import (
    Doubted,
    Frame,
    Inconsistent,
    InvalidInput,
    Polygon,
    Position,
    Range,
    SetMembershipFilter,
    Suspect,
    Team,
    Tolerance,
    Tolerated,
)
from filter.diagnosis.told import without
from filter.diagnosis.tolerance import BY_VOTES, CLASSES
from filter.records.record import field_names

ROUNDING = 1e-9  # [m]


@pytest.mark.parametrize("seed", [1])
@pytest.mark.parametrize("suspects", [each for each in CLASSES if each != BY_VOTES])
def test_the_truth_is_inside_while_one_lies_in_any_window(suspects, seed):
    episode, rng = drawn("compass", 30 + seed), np.random.default_rng([seed, len(suspects)])
    good = [frame for k, frame in enumerate(episode.frames) if k < episode.fault.when]
    assert len(good) > 5
    frames = one_liar_a_window(good, suspects_in(good, suspects), WINDOW, rng)
    filter_ = light(episode.team, suspects)
    belief = filter_.start(0.0, episode.positions, episode.headings)
    for frame in frames:
        belief = stepped(filter_, belief, frame)
        assert not outside(belief, frame.truth).any()
        assert belief.guarantee.in_force.all()
        for one, other in pairwise(belief.alternatives.cases):
            assert one != other


@pytest.mark.parametrize("lies", ["any", "long"])
@pytest.mark.parametrize("seed", [1])
def test_the_truth_is_inside_where_ranges_alone_are_measured(lies, seed):
    scene, rng = DRIVES[seed].drawn([seed, 5], 18, 0.1), np.random.default_rng(seed)
    frames = one_liar_a_window(scene.frames, suspects_in(scene.frames), 1.0, rng, long=lies == "long")
    filter_ = tolerant(scene.team, lies=lies, window=1.0)
    belief = filter_.start(0.0, scene.initial, scene.headings)
    for frame in frames:
        belief = stepped(filter_, belief, frame)
        assert not outside(belief, frame.truth).any()


@pytest.mark.parametrize("lies", ["any", "long"])
def test_each_case_is_the_strict_filter_without_what_a_suspect_says(lies):
    """The slow and obvious version: a strict filter for each suspect."""
    scene = team_that_stands(np.random.default_rng(3), 0.1)
    tolerance, strict = Tolerance(lies=lies, window=9.0), SetMembershipFilter(scene.team)
    filter_ = SetMembershipFilter(scene.team, tolerance=tolerance)
    belief = filter_.start(0.0, scene.initial, scene.headings)
    for frame in scene.frames:
        belief = stepped(filter_, belief, frame)
    assert len(belief.alternatives.each) == 1 + len(suspects_in(scene.frames))
    for one in belief.alternatives.each:
        for around, region in zip(belief.regions, one.belief.regions, strict=True):
            assert (region.outer.support(around.outer.normals) <= around.outer.offsets + ROUNDING).all()
    for one in belief.alternatives.each[::6]:
        alone_ = strict.start(0.0, scene.initial, scene.headings)
        for frame in scene.frames:
            alone_ = stepped(strict, alone_, replace(frame, measurements=tolerance.believed(one.lying, frame.measurements)))
        assert known(one.belief) == known(alone_)


@pytest.mark.parametrize("seed", range(4))
def test_long_lies_cost_less_than_any_and_those_less_than_more(seed):
    scene = alone(np.random.default_rng(seed), 5, 0.1)
    strict = followed_in(scene, SetMembershipFilter(scene.team))
    long, anything, two = (followed_in(scene, tolerant(scene.team, **which)) for which in ({"lies": "long"}, {}, {"q": 2}))
    areas = [belief.regions[0].outer.area for belief in (strict, long, anything, two)]
    assert areas == sorted(areas)
    assert areas[0] < areas[-1]


@pytest.mark.parametrize("seed", range(4))
def test_two_that_lie_at_once_are_two(seed):
    rng = np.random.default_rng(seed)
    scene = alone(rng, 6, 0.1)
    truth = scene.frames[0].truth
    frame = lied(lied(scene.frames[0], Suspect("sighting", 0, 2), rng, size=2.5), Suspect("sighting", 0, 5), rng, size=3.5)
    frame = replace(frame, time=2.0, measurements=tuple(replace(each, time=2.0) for each in frame.measurements))
    before = [followed_in(scene, tolerant(scene.team, q=q)) for q in (1, 2)]
    assert not outside(stepped(tolerant(scene.team, q=2), before[1], frame), truth).any()
    try:
        belief = stepped(tolerant(scene.team), before[0], frame)
    except Inconsistent as error:
        named = {source.target for source in error.sources if source.kind == "range"}
        (record,) = frame.measurements
        columns = {name: getattr(record, name)[np.isin(record.target, list(named))] for name in field_names(record)}
        is_known = any(source.kind == "region" for source in error.sources)
        anywhere = tolerant(scene.team).start(before[0].time, scene.initial, scene.headings)
        around = replace(before[0], alternatives=None) if is_known else anywhere
        with pytest.raises(Inconsistent):  # what is named is too much for the tolerance by itself
            stepped(tolerant(scene.team), around, replace(frame, measurements=(replace(record, **columns),)))
    else:
        assert belief.guarantee.in_force.all()


def test_exchanged_markers_are_two_bodies():
    episode = drawn("swap", 2)
    filter_ = tolerant(episode.team, "bodies", q=2, window=60.0)
    belief = filter_.start(0.0, episode.positions, episode.headings)
    for frame in episode.frames[:18]:
        belief = stepped(filter_, belief, frame)
        assert not outside(belief, frame.truth).any()
    assert any(len(case) == 2 for case in belief.alternatives.cases)


def test_it_says_what_it_tolerates_and_who_can_have_lied():
    episode = drawn(None, 31)
    rng, filter_ = np.random.default_rng(0), tolerant(episode.team, window=60.0)
    belief = filter_.start(0.0, episode.positions, episode.headings)
    words = "in force if at most 1 of these is wrong within any 60 s: what a robot takes for a target"
    assert str(belief.guarantee) == words
    liar, told = suspects_in(episode.frames[5:6])[0], []
    for k, frame in enumerate(episode.frames[:10]):
        belief = stepped(filter_, belief, lied(frame, liar, rng, size=4.0) if k >= 5 else frame)
        told += [event for event in belief.events if isinstance(event, Tolerated)]
        assert str(belief.guarantee) == words
        assert belief.agrees == (not belief.suspects)
    assert liar in {replace(each, since=0.0) for each in belief.suspects}
    assert told
    assert told[-1].cases == belief.alternatives.cases
    assert "tolerated" in str(told[0])


def test_the_order_of_records_makes_no_difference_and_a_pickle_goes_on():
    episode = drawn(None, 32)
    filter_ = light(episode.team, ("bodies", "cameras"))
    belief = filter_.start(0.0, episode.positions, episode.headings)
    for frame in episode.frames[:3]:
        shuffled = replace(frame, measurements=tuple(reversed([_reversed(each) for each in frame.measurements])))
        copy = pickle.loads(pickle.dumps(belief))
        belief, other = (stepped(filter_, one, some) for one, some in ((belief, frame), (copy, shuffled)))
        assert known(belief) == known(other)
        assert belief.alternatives.cases == other.alternatives.cases


def _reversed(record):
    return replace(record, **{name: value[::-1] for name, value in vars(record).items() if isinstance(value, np.ndarray)})


def test_several_instants_at_once_hold_the_truth_although_one_lies():
    scene, rng = DRIVES[1].drawn([4, 8], 16, 0.1), np.random.default_rng(4)
    frames = one_liar_a_window(scene.frames, suspects_in(scene.frames), 1.0, rng)
    filter_ = tolerant(scene.team, window=1.0)
    belief = filter_.start(0.0, scene.initial, scene.headings)
    for first in range(0, len(frames), 4):
        belief = filter_.advance(belief, frames[first : first + 4])
        assert not outside(belief, frames[first + 3].truth).any()


def test_one_more_than_is_tolerated_is_a_doubt_and_the_truth_stays_inside():
    rng, seen = np.random.default_rng(1), False
    scene = alone(rng, 8, 0.1)
    frame = scene.frames[0]
    for target in (2, 5):
        frame = lied(frame, Suspect("sighting", 0, target), rng, size=4.0)
    filter_ = going_on(scene.team, tolerance=Tolerance(window=60.0))
    belief = filter_.start(0.0, scene.initial, scene.headings)
    for k in range(1, 4):
        later = replace(frame, time=float(k), measurements=tuple(replace(each, time=float(k)) for each in frame.measurements))
        belief = stepped(filter_, belief, later)
        seen |= any(isinstance(event, Doubted) for event in belief.events)
        assert not outside(belief, frame.truth).any()
        assert "at most 1 of these" in str(belief.guarantee)
    assert seen


def test_a_robot_that_is_placed_is_so_in_each_case():
    episode = drawn(None, 33)
    filter_ = tolerant(episode.team)
    belief = followed(episode, filter_, 3)[-1]
    truth = episode.frames[2].truth
    belief = filter_.placed(belief, 1, Polygon.box(truth.positions[1] - 0.3, truth.positions[1] + 0.3))
    assert all(one.belief.regions[1].outer.area == pytest.approx(0.36) for one in belief.alternatives.each)
    later = stepped(filter_, belief, Frame(belief.time, None, episode.frames[2].measurements))
    assert not outside(later, truth).any()


def test_a_suspended_guarantee_stays_so():
    """Two robots are told to be in two places each: more is wrong than is tolerated, and all start over."""
    team = Team(2, [[4.0, 0.0]], arena=[[-9, -9], [9, 9]])
    filter_ = going_on(team, tolerance=Tolerance())
    belief = filter_.start(0.0, [Polygon.box([-9, -9], [9, 9]), Polygon.box([-2, -2], [2, 2])])
    belief = filter_.update(belief, [Position(0.0, robot, [1.0, -1.0], 0.0, [0.5, -1.5]) for robot in (0, 1)])
    assert belief.guarantee.lapsed.all()
    for time in (0.0, 1.0, 7.0):
        belief = stepped(filter_, belief, Frame(time, None, ()))
        assert belief.guarantee.lapsed.all()


def test_what_holds_under_another_tolerance_is_refused():
    team = Team(1, [[3.0, 0.0]])
    filters = [SetMembershipFilter(team), *(tolerant(team, lies=lies, q=q) for lies in ("any", "long") for q in (1, 2))]
    for one in filters:
        for other in filters:
            belief = one.start(0.0, [Polygon.box([-1, -1], [1, 1])])
            if one is other:
                assert other.predict(other.update(belief, []), 1.0).guarantee.in_force.all()
                continue
            with pytest.raises(InvalidInput, match="a belief that holds"):
                other.update(belief, [])
            with pytest.raises(InvalidInput, match="a belief that holds"):
                other.predict(belief, 1.0)


def test_lies_of_two_that_are_a_window_apart_are_in_two_windows():
    rng, scene = np.random.default_rng(2), alone(np.random.default_rng(2), 6, 0.1)
    filter_ = tolerant(scene.team, window=5.0)
    belief = filter_.start(0.0, scene.initial, scene.headings)
    for time in (0.6000000000000001, 3.0, 5.6000000000000005, 7.0):
        frame = replace(
            scene.frames[0], time=time, measurements=tuple(replace(each, time=time) for each in scene.frames[0].measurements)
        )
        who = {0.6000000000000001: 2, 5.6000000000000005: 5}.get(time)
        belief = stepped(filter_, belief, lied(frame, Suspect("sighting", 0, who), rng, size=3.0) if who else frame)
        assert not outside(belief, frame.truth).any()


def test_what_is_not_believed_has_to_be_right_in_form_when_several_come_at_once():
    scene = alone(np.random.default_rng(3), 5, 0.1)
    filter_ = tolerant(scene.team, "cameras")
    belief = filter_.start(0.0, scene.initial, scene.headings)
    wrong = Range(1.0, 0, 77, 1.0, 0.1, 0.0)
    with pytest.raises(InvalidInput):
        filter_.advance(belief, [Frame(1.0, None, (wrong,)), Frame(1.5, None, ())])


def test_without_a_tolerance_nothing_is_kept():
    episode = drawn(None, 34)
    one, other = followed(episode, SetMembershipFilter(episode.team), 4)[-1], followed(episode, going_on(episode.team), 4)[-1]
    assert one.alternatives is other.alternatives is None
    assert str(one.guarantee) == "in force"
    assert without(Suspect("past", 0), episode.frames[0].measurements) == episode.frames[0].measurements
