"""From a conflict on: the truth stays inside, whatever one thing is wrong, until it is found out, and afterwards."""

import pickle
from dataclasses import replace
from functools import cache
from gc import collect
from weakref import ref

import numpy as np
import pytest
from helpers.drawn.broken import culprit, drawn, followed, going_on, outside, stepped
from helpers.drawn.tolerant import known
from helpers.teams import snapshot
from helpers.worlds import exact_claim

from experiments.broken.fault import KINDS
from filter import Budget, Directions, Doubted, FixedLag, Inconsistent, Judged, Polygon, SetMembershipFilter, Suspect
from filter.diagnosis.evidence import FITS
from filter.diagnosis.judging import _acquitted, judged
from filter.diagnosis.quiet import MEMORY, _tried
from filter.diagnosis.starting_over import new_trial
from filter.diagnosis.told import signature, without
from filter.projection.stop import never
from filter.sets.belief import Hypothesis

ROUNDING = 1e-9  # [m]
SOON = 3  # so many frames can a fault be there before it is proved


def without_diagnosis(belief):
    return snapshot(replace(belief, diagnosis=None))


@cache
def doubtful(kind="misread", seed=1, landmarks=4, *, each_alone=False):
    """Return an episode, the beliefs up to the first that is in doubt, and the frames after it."""
    episode = drawn(kind, seed, landmarks)
    beliefs = followed(episode, going_on(episode.team, each_alone=each_alone))
    first = next(k for k, belief in enumerate(beliefs) if belief.suspects)
    return episode, beliefs[: first + 1], episode.frames[first + 1 :]


@pytest.mark.parametrize("landmarks", [4, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_the_truth_is_inside_from_the_conflict_on(kind, landmarks):
    episode = drawn(kind, 3, landmarks)
    beliefs = followed(episode)
    doubts = [k for k, belief in enumerate(beliefs) if any(isinstance(event, Doubted) for event in belief.events)]
    first = doubts[0] if doubts else len(beliefs)
    for belief, frame in list(zip(beliefs, episode.frames, strict=True))[first:]:
        assert not outside(belief, frame.truth).any()
    if landmarks == 4:
        assert first <= episode.fault.when + SOON
        assert beliefs[-1].guarantee.in_force.all()
        if episode.fault.lasts:
            assert [suspect.who for suspect in beliefs[-1].aside] == [culprit(episode.fault)]


@pytest.mark.parametrize("landmarks", [4, 2])
def test_where_nothing_is_wrong_it_is_the_strict_filter_bit_by_bit(landmarks):
    episode = drawn(None, 1, landmarks)
    strict, kept = followed(episode, SetMembershipFilter(episode.team), 12), followed(episode, count=12)
    for one, other in zip(strict, kept, strict=True):
        assert without_diagnosis(one) == without_diagnosis(other)
        assert one.diagnosis is None
        assert len(other.diagnosis.recent) <= MEMORY
        assert other.suspects == other.aside == ()
        assert str(other.guarantee) == "in force"


def test_nothing_older_than_the_last_instants_is_kept():
    episode = drawn(None, 2)
    filter_ = going_on(episode.team)
    belief, old = filter_.start(0.0, episode.positions, episode.headings), []
    for frame in episode.frames[: MEMORY + 6]:
        belief = stepped(filter_, belief, frame)
        old.append(ref(belief.polytope))
        assert all(each.before.diagnosis is each.before.moved is None for each in belief.diagnosis.recent)
    collect()
    twice = filter_.predict(filter_.predict(belief, belief.time + 1), belief.time + 2)
    assert twice.moved is not None
    assert all(each.before.moved is None for each in twice.diagnosis.recent)
    assert sum(each() is not None for each in old) == MEMORY + 1


def test_the_order_of_records_makes_no_difference():
    episode, beliefs, frames = doubtful()
    for before, frame in ((beliefs[-2], episode.frames[len(beliefs) - 1]), (beliefs[-1], frames[0])):
        shuffled = [
            replace(record, **{name: value[::-1] for name, value in vars(record).items() if isinstance(value, np.ndarray)})
            for record in reversed(frame.measurements)
        ]
        filter_ = going_on(episode.team)
        one, other = (stepped(filter_, before, replace(frame, measurements=some)) for some in (frame.measurements, shuffled))
        assert without_diagnosis(one) == without_diagnosis(other)
        assert one.suspects == other.suspects
        for left, right in zip(one.diagnosis.hypotheses, other.diagnosis.hypotheses, strict=True):
            assert without_diagnosis(left.belief) == without_diagnosis(right.belief)


def test_it_goes_on_from_a_pickle_as_from_the_belief_itself():
    episode, beliefs, frames = doubtful()
    filter_, copy = going_on(episode.team), pickle.loads(pickle.dumps(beliefs[-1]))
    one, other = (stepped(filter_, belief, frames[0]) for belief in (beliefs[-1], copy))
    assert without_diagnosis(one) == without_diagnosis(other)
    assert one.suspects == other.suspects


def test_what_is_said_names_who_can_be_wrong_and_the_assumption():
    episode, beliefs, _ = doubtful()
    belief = beliefs[-1]
    event = next(event for event in belief.events if isinstance(event, Doubted))
    assert event.suspects == belief.suspects
    assert event.since >= episode.frames[len(beliefs) - 1].time - MEMORY
    assert str(belief.guarantee).startswith(f"in force if only one of these is wrong since {event.since:.3f} s: ")
    assert belief.guarantee.in_force.all()
    assert episode.team.words(event).startswith("in doubt since ")
    assert belief.proofs == ()
    assert culprit(episode.fault) in {suspect.who for suspect in belief.suspects}


def test_of_each_case_it_is_kept_for_a_step_why_it_cannot_be_or_what_is_known():
    episode, beliefs, frames = doubtful(each_alone=True)
    known = beliefs[-1].diagnosis
    ended = [one for one in known.tried if one.end]
    assert {one.name for one in known.tried} - {one.name for one in ended} == {case.name for case in known.hypotheses}
    assert len(ended) > len(known.hypotheses)
    assert {one.name for one in doubtful()[1][-1].diagnosis.tried} < {one.name for one in known.tried}  # some of them together
    for one in ended:
        nothing = one.end[1][-1]
        assert isinstance(nothing, Directions) or nothing.of == "nothing"
        assert isinstance(nothing, Directions) or exact_claim(nothing, 0) < 0
    later = stepped(going_on(episode.team, each_alone=True), beliefs[-1], frames[0])
    assert {one.parent for one in later.diagnosis.tried} == {case.name for case in known.hypotheses}
    assert all(len(one.beliefs) == 1 for one in later.diagnosis.tried if not one.end)


def test_regions_arcs_and_pairs_hold_in_each_case():
    episode, beliefs, frames = doubtful()
    filter_ = going_on(episode.team)
    later = filter_.predict(beliefs[-1], frames[0].time, frames[0].odometry)
    pairs = np.array([0, 2]), np.array([1, 0])
    for belief in (beliefs[-1], later):
        relative = filter_.relative(belief, *pairs)
        for case in belief.diagnosis.hypotheses:
            for one, other in zip(belief.regions, case.belief.regions, strict=True):
                assert (other.outer.support(one.outer.normals) <= one.outer.offsets + ROUNDING).all()  # boxes cut, too
            ends = (case.belief.headings.centre + share * case.belief.headings.bound for share in (-1, 0, 1))
            assert all(belief.headings.contains(angle).all() for angle in ends)
            single = SetMembershipFilter(episode.team).relative(case.belief, *pairs)
            for one, other in zip(relative, single, strict=True):
                assert (other.support(one.normals) <= one.offsets + ROUNDING).all()
        assert (belief.polytope.lower <= np.min([each.belief.polytope.lower for each in belief.diagnosis.hypotheses], 0)).all()


def test_a_robot_that_is_placed_is_so_in_each_case():
    episode, beliefs, _ = doubtful()
    truth = episode.frames[len(beliefs) - 1].truth
    box = Polygon.box(truth.positions[1] - 0.3, truth.positions[1] + 0.3)
    belief = going_on(episode.team).placed(beliefs[-1], 1, box)
    assert belief.regions[1].outer.area == pytest.approx(0.36)
    assert belief.suspects == beliefs[-1].suspects
    assert all(case.belief.regions[1].outer.area == pytest.approx(0.36) for case in belief.diagnosis.hypotheses)
    assert belief.diagnosis.recent == ()
    assert belief.guarantee.assuming == beliefs[-1].guarantee.assuming


def test_several_instants_at_once_are_a_step_for_each_in_a_doubt():
    episode, beliefs, frames = doubtful()
    filter_ = going_on(episode.team)
    together = filter_.advance(beliefs[-1], frames[:2])
    apart = stepped(filter_, stepped(filter_, beliefs[-1], frames[0]), frames[1])
    assert snapshot(together.polytope) == snapshot(apart.polytope)
    assert together.suspects == apart.suspects


def test_a_conflict_among_several_instants_at_once_begins_a_doubt():
    episode, beliefs, _ = doubtful()
    filter_, at = going_on(episode.team), len(beliefs) - 1
    belief = filter_.advance(beliefs[at - 3], episode.frames[at - 2 : at + 1])
    assert belief.suspects
    assert any(isinstance(event, Doubted) for event in belief.events)
    assert not outside(belief, episode.frames[at].truth).any()


def test_late_records_are_merged_as_if_they_had_come_in_order():
    episode, beliefs, _ = doubtful()
    at = len(beliefs) - 1
    lag = FixedLag(going_on(episode.team), lag=9.0)
    known = lag.begin(beliefs[at - 2])
    frames = episode.frames[at - 1 : at + 2]
    known = lag.merge(known, [frames[0].odometry, frames[1].odometry, frames[2].odometry, *frames[2].measurements])
    known = lag.merge(known, [*frames[0].measurements, *frames[1].measurements])
    belief = stepped(going_on(episode.team), beliefs[-1], frames[2])
    assert snapshot(known.belief.polytope) == snapshot(belief.polytope)
    assert known.belief.suspects == belief.suspects


def test_the_policy_that_raises_raises_and_keeps_nothing():
    episode, beliefs, _ = doubtful()
    strict, at = SetMembershipFilter(episode.team), len(beliefs) - 1
    before = followed(episode, strict, at)[-1]
    with pytest.raises(Inconsistent):
        stepped(strict, before, episode.frames[at])
    assert before.diagnosis is None


def test_who_is_put_aside_is_trusted_again_when_all_has_agreed_for_long():
    episode = drawn("compass", 3)
    events = [event for belief in followed(episode) for event in belief.events if isinstance(event, Judged)]
    verdicts = [(event.verdict, event.suspect.who) for event in events]
    robot = episode.fault.robot
    assert ("guilty", ("compass", robot, -1)) in verdicts
    assert ("trusted again", ("compass", robot, -1)) in verdicts
    assert str(Judged(1.0, Suspect("compass", 2), "guilty", "proof")) == "guilty, by proof: compass of robot 2"


def test_who_is_right_again_was_perhaps_wrong_before_so_what_is_known_then_stays():
    """Both of two suspects are acquitted by a third: their beliefs become one that contains both."""
    episode, beliefs, _ = doubtful()
    known = beliefs[-1].diagnosis
    one, other, third = (Suspect("past", robot) for robot in range(3))
    left, right = beliefs[1].alone, beliefs[2].alone
    used = {("sensor", 0, -1): 99, ("sighting", 0, 4): 99, ("sighting", 0, 5): 99, ("body", -1, 1): 99, ("sighting", 1, 4): 99}
    used |= {("sighting", 1, 5): 99, ("compass", 1, -1): 99}
    cases = [Hypothesis((one,), left, fits=FITS), Hypothesis((other,), right, fits=FITS), Hypothesis((third,), left, used)]
    now = replace(known, hypotheses=tuple(cases), metres=np.full(3, 9.0))
    found, freed = _acquitted(going_on(episode.team)._strict(never), now, ())
    living = found.hypotheses
    assert set(freed) == {one, other}
    assert [case.is_over for case in living] == [False, True]
    assert set(living[1].suspects) == {one, other}
    for before in (left, right):
        for hull, region in zip(living[1].belief.regions, before.regions, strict=True):
            assert (region.outer.support(hull.outer.normals) <= hull.outer.offsets + ROUNDING).all()
    assert episode.fault.kind == "misread"
    lied = [replace(case, agreed=False) for case in cases]  # what was used agreed only as a lie was tolerated
    found, freed = _acquitted(going_on(episode.team)._strict(never), replace(now, hypotheses=tuple(lied)), ())
    assert [(case.suspects, case.belief) for case in found.hypotheses] == [(case.suspects, case.belief) for case in lied]
    assert freed == ()


def test_a_sighting_that_is_left_alone_is_put_aside_and_what_is_known_holds_in_each_case():
    episode, beliefs, _ = doubtful()
    cases = [
        Hypothesis((Suspect("sighting", 0, 4),), beliefs[1].alone, name="1"),
        Hypothesis((Suspect("sensor", 0),), beliefs[2].alone, is_over=True, name="2"),
        Hypothesis((Suspect("body", None, 4),), beliefs[0].alone, is_over=True, name="3"),
    ]
    now = replace(beliefs[-1].diagnosis, hypotheses=tuple(cases), by_proof=False)
    found = judged(going_on(episode.team)._strict(never), now, ())
    assert [suspect.who for suspect in found.aside] == [("sighting", 0, 4)]
    assert [(event.verdict, event.by) for event in found.events if isinstance(event, Judged)] == [("guilty", "evidence")]
    for case in cases:
        for hull, region in zip(found.regions, case.belief.regions, strict=True):
            assert (region.outer.support(hull.outer.normals) <= hull.outer.offsets + ROUNDING).all()
    pasts = replace(now, hypotheses=(replace(cases[0], suspects=(Suspect("past", 0),)), *cases[1:]))
    assert len(judged(going_on(episode.team)._strict(never), pasts, ()).diagnosis.hypotheses) == 2


def test_a_trial_of_somebody_silent_says_no_more_than_is_known():
    """The slow and obvious version: a belief of its own from the beginning on is the same until its suspect speaks."""
    episode = drawn(None, 2)
    filter_ = going_on(episode.team)
    strict, belief = filter_._strict(never), filter_.start(0.0, episode.positions, episode.headings)
    bodies = episode.team.robots + len(episode.team.landmarks)
    trials = [new_trial(strict, Suspect("body", None, target), 0.0) for target in range(bodies)]
    for frame in episode.frames[:3]:
        told = tuple(frame.measurements)
        before = filter_.predict(belief, frame.time, frame.odometry).alone if frame.odometry else belief.alone
        belief = filter_.update(before, told)
        for trial in trials:
            left = without(trial.suspect, told)
            found = _tried(strict, (before, filter_.update(before, left).alone), trial, told)
            is_silent = signature(left) == signature(told)
            assert found.used[("body", -1, trial.suspect.target)] >= 1 or is_silent
            assert found.belief is None or not is_silent
            assert found.belief is None or known(found.belief) == known(belief)


@pytest.mark.parametrize("landmarks", [4])
def test_with_a_budget_that_is_over_at_once_the_truth_is_inside_all_the_same(landmarks):
    episode, clock = drawn("moved", 1, landmarks), iter(range(10**9))
    beliefs = followed(episode, going_on(episode.team, budget=Budget(0.5, lambda: float(next(clock)))), 24)
    for belief, frame in zip(beliefs[episode.fault.when + 2 :], episode.frames[episode.fault.when + 2 :], strict=False):
        assert not outside(belief, frame.truth).any()
