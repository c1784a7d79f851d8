"""Where more than one thing is wrong, robots start over, suspended and apart, until all has agreed for long."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drawn.broken import drawn, followed, going_on, outside, stepped

from filter import (
    Compass,
    Confirmed,
    Left,
    Odometry,
    Polygon,
    Position,
    Range,
    SetMembershipFilter,
    StartsOver,
    Suspect,
    Team,
)
from filter.sets.belief import Diagnosis, Trial


def nowhere(time, robot):
    """Return a position that nobody can be at."""
    return Position(time, robot, [1.0, -1.0], 0.0, [0.5, -1.5])


def twice_wrong(at=4, count=30):
    """Yield frames, in one of which two robots say what cannot be, and the beliefs after each."""
    episode = drawn(None, 5)
    filter_ = going_on(episode.team)
    belief = filter_.start(0.0, episode.positions, episode.headings)
    for k, frame in enumerate(episode.frames[:count]):
        lies = [nowhere(frame.time, 0), nowhere(frame.time, 1)] if k == at else []
        belief = stepped(filter_, belief, replace(frame, measurements=[*frame.measurements, *lies]))
        yield frame, belief


def test_they_are_suspended_and_in_force_again_when_all_has_agreed_for_long():
    events, suspended = [], []
    for frame, belief in twice_wrong():
        assert not outside(belief, frame.truth).any()
        assert belief.regions.contains(frame.truth.positions).all()
        events += [(frame.time, event) for event in belief.events if isinstance(event, StartsOver | Confirmed)]
        suspended.append(belief.guarantee.lapsed.any())
    (begun, event), *later = events
    assert isinstance(event, StartsOver)
    assert begun == 4.0
    assert suspended[3:6] == [False, True, True]
    assert {confirmed.robot for _, confirmed in later} == set(event.robots)
    assert min(time for time, _ in later) >= begun + 10
    assert not suspended[-1]
    assert str(belief.guarantee) == "in force"
    assert belief.diagnosis.suspended == ()


def test_those_who_start_over_can_be_anywhere_and_nothing_ties_them_to_the_others():
    episode = drawn("kidnap", 0)
    filter_ = going_on(episode.team)
    belief = followed(episode, filter_, 3)[-1]
    time = belief.time
    records = [nowhere(time, 0), replace(nowhere(time, 0), normal_x=[-1.0, 1.0])]
    compass = Compass(time, [1, 1], [0.0, 2.0], 0.1)
    belief = filter_.update(belief, [*records, compass])
    (event,) = [event for event in belief.events if isinstance(event, StartsOver)]
    apart = sorted(event.robots)
    assert belief.guarantee.lapsed[apart].all()
    assert belief.regions.outer.areas[apart] == pytest.approx(144.0)
    seen = [Range(time, apart[0], 2, 1.0, 0.1, 0.0)] if 2 not in apart else []
    assert (filter_.update(belief, seen).regions.outer.areas >= belief.regions.outer.areas - 1e-9).all()


def test_a_conflict_among_those_who_start_over_lets_them_start_over_again():
    *_, (frame, belief) = twice_wrong(count=7)
    before = [trial.used for trial in belief.diagnosis.suspended]
    assert all(before)
    filter_ = going_on(drawn(None, 5).team)
    robot = belief.diagnosis.suspended[0].suspect.robot
    later = filter_.predict(belief, frame.time + 1, Odometry(frame.time, frame.time + 1, [0, 1, 2], 0.0, 0.1, 0, 4, 0.1, 0.1))
    after = filter_.update(later, [nowhere(frame.time + 1, robot)])
    (event,) = [event for event in after.events if isinstance(event, StartsOver)]
    assert set(event.robots) == set(event.unheard) == {trial.suspect.robot for trial in after.diagnosis.suspended}
    assert event.conflict
    assert all(trial.used == {} for trial in after.diagnosis.suspended)
    assert after.guarantee.lapsed[robot]


def test_nobody_in_force_relies_on_who_starts_over():
    team = Team(2, [[4.0, 0.0]], arena=[[-9, -9], [9, 9]])
    filter_ = SetMembershipFilter(team, policy="reject")
    belief = filter_.start(0.0, [Polygon.box([-9, -9], [9, 9]), Polygon.box([-2, -2], [2, 2])])
    trial = Trial(Suspect("past", 0), 0.0, None, {}, np.zeros(2))
    alone = replace(belief, diagnosis=Diagnosis(suspended=(trial,)), guarantee=belief.guarantee.suspended(0.0, "a lie", {0}))
    for lie in (Range(0.0, 0, 1, 0.1, 0.1, 0.0), Range(0.0, 1, 0, 0.1, 0.1, 0.0)):
        after = filter_.update(alone, [lie, Range(0.0, 0, 2, 1.0, 0.1, 0.0)])
        assert after.regions[1].outer.area == pytest.approx(16.0)
        assert after.regions[0].outer.area < 10
        assert after.guarantee.in_force.tolist() == [False, True]


def test_nobody_who_starts_over_relies_on_another_one_who_does():
    """One of them may be misread by the other: it can be anywhere, so that nothing contradicts that."""
    team = Team(2, [[4.0, 0.0]], arena=[[-9, -9], [9, 9]])
    belief = SetMembershipFilter(team, policy="reject").start(0.0, [Polygon.box([-9, -9], [9, 9])] * 2)
    trials = tuple(Trial(Suspect("past", robot), 0.0, None, {}, np.zeros(2)) for robot in range(2))
    belief = replace(belief, diagnosis=Diagnosis(suspended=trials), guarantee=belief.guarantee.suspended(0.0, "a lie", {0, 1}))
    seen = [Range(0.0, 0, 1, 0.1, 0.1, 0.0), Range(0.0, 0, 2, 1.0, 0.1, 0.0)]
    after = SetMembershipFilter(team, policy="reject").update(belief, seen)
    assert after.regions[1].outer.area == pytest.approx(324.0)
    assert after.regions[0].outer.area < 10


def around(places, time, reach=0.3):
    """Return a position for each of some robots, in a square around a place."""
    return [Position.within(time, robot, Polygon.box(np.subtract(p, reach), np.add(p, reach))) for robot, p in places.items()]


@pytest.mark.parametrize("second", [1, 2])
def test_who_is_in_a_second_conflict_starts_over_and_the_others_stay_in_force(second):
    team = Team(4, speed_limit=0.05, arena=[[-6.0, -6.0], [6.0, 6.0]])
    filter_, truth = going_on(team), {robot: (3.0 * robot - 4.5, 0.0) for robot in range(4)}
    belief = filter_.start(0.0, [Polygon.box(np.subtract(place, 1.0), np.add(place, 1.0)) for place in truth.values()])
    for time in (1.0, 2.0, 3.0):
        lies = {0: (-4.5, 4.0)} if time == 3.0 else {}
        belief = filter_.update(filter_.predict(belief, time), around(truth | lies, time))
    assert len(belief.diagnosis.hypotheses) > 1
    said = replace(belief, diagnosis=None)
    belief = filter_.predict(belief, 4.0)
    belief = filter_.update(belief, around(truth | {second: (4.5, -4.0)}, 4.0))
    (event,) = [event for event in belief.events if isinstance(event, StartsOver)]
    assert event.robots == (0, second)
    assert {source.robot for source in event.conflict if not isinstance(source, Suspect)} == {second}
    assert belief.guarantee.lapsed.tolist() == [robot in event.robots for robot in range(4)]
    assert "only one of these" in said.guarantee.assuming
    assert not belief.guarantee.assuming  # it is proved to be more
    others = [robot for robot in range(4) if robot not in event.robots]
    assert (belief.regions.outer.areas[others] < 1).all()
    assert belief.regions.contains(np.array(list(truth.values())))[others].all()
    expected = SetMembershipFilter(team).update(SetMembershipFilter(team).predict(said, 4.0), around(truth, 4.0))
    assert belief.regions.outer.areas[others] == pytest.approx(expected.regions.outer.areas[others])


def waiting(*robots):
    """Return a team of two of which some have started over, and what is known."""
    filter_ = going_on(Team(2, [[4.0, 0.0]], arena=[[-9, -9], [9, 9]]))
    belief = filter_.start(0.0, [Polygon.box([-9, -9], [9, 9])] * 2)
    trials = tuple(Trial(Suspect("past", robot), 0.0, None, {}, np.zeros(2)) for robot in robots)
    return filter_, replace(belief, diagnosis=Diagnosis(suspended=trials))


def test_in_a_doubt_of_the_others_nobody_listens_to_who_starts_over():
    filter_, belief = waiting(0)
    later = filter_.predict(belief, 1.0)
    doubted = filter_.update(later, [nowhere(1.0, 1), *around({0: (0.0, 0.0)}, 1.0), Range(1.0, 0, 2, 1.0, 0.1, 0.0)])
    tried = {suspect.who for one in doubted.diagnosis.tried for suspect in one.suspects}
    assert ("sensor", 1, -1) in tried
    assert not {("sensor", 0, -1), ("body", -1, 2)} & tried


def test_who_is_away_does_not_come_back_to_start_over_again():
    filter_, belief = waiting(0, 1)
    belief = filter_.changed(belief, Left(0.0, 0))
    belief = filter_.update(filter_.predict(belief, 1.0), [nowhere(1.0, 1)])
    (event,) = belief.events
    assert event.robots == (1,)
    assert belief.guarantee.away == {0}
