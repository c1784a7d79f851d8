"""A camera whose clock is late is suspected, and no other; nothing of it is merged until it is known to be right again."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.robust_worlds import GUILTY, inside, missing, started, turned_in, world_of

from filter import Bearing, Range
from filter.geometry.angles import wrap
from filter.robust.belief import Late, Restarted
from filter.robust.robust_filter import RobustFilter
from filter.robust.votes import Rules


def later(records, before, time, guilty):
    """Return records with those of one robot's camera as they were some steps before, with the time of now."""
    others, own = ([r for r in each if isinstance(r, Bearing | Range)] for each in (records, before))
    chosen = [(r, r.robot != guilty) for r in others] + [(r, r.robot == guilty) for r in own]
    return [part(r, mask, time) for r, mask in chosen]


def part(record, mask, time):
    columns = {name: column[mask] for name, column in vars(record).items() if isinstance(column, np.ndarray)}
    return replace(record, **columns, time=time)


def late_touring(world, count, during, carried=None, guilty=GUILTY):
    """Yield the belief at each of many steps; one camera is late by 0.6 s for a while. Turns last 2 s.

    Its robot may be carried elsewhere at a step.
    """
    robots, step, steps = world.robots, 0.2, 3
    robust, seen, path = RobustFilter(world.team), [], np.full(robots, 0.15 * step)
    belief = started(robust, world, "pose")
    for k in range(count):
        if k % 10 == 0:
            away = world.size / 2 - world.positions
            home = np.clip(wrap(np.arctan2(away[:, 1], away[:, 0]) - world.headings) / 2, -0.6, 0.6)
            rate = np.where(np.hypot(*away.T) > world.size / 2, home, world.rng.uniform(-0.6, 0.6, robots))
        if k == carried:
            theirs = np.arange(robots) == guilty
            world.positions = np.where(theirs[:, None], world.size - world.positions, world.positions)
            world.headings = wrap(world.headings + 2.5 * theirs)
        belief = robust.predict(belief, world.time + step, world.drive(path, step * rate, step))
        seen.append(world.measure(compasses=False))
        wrong = during[0] + steps <= k < during[1]
        belief = robust.update(belief, later(seen[-1], seen[-1 - steps], world.time, guilty) if wrong else seen[-1])
        yield belief


def told(beliefs):
    return [event for belief in beliefs for event in belief.events if isinstance(event, Late)]


@pytest.mark.parametrize(("begins", "seed"), [(0, 0), (100, 1)])
def test_a_late_camera_is_suspected_and_from_then_on_does_no_harm(seed, begins):
    world, beliefs = world_of(seed), []
    for belief in late_touring(world, begins + 300, (begins, np.inf)):
        beliefs.append(belief)
        places, headings = inside(belief, world)
        if len(beliefs) <= begins or belief.offsets.late[GUILTY]:
            assert places.all()
            assert headings.all()
    (event,) = told(beliefs)
    assert (event.robot, event.aside) == (GUILTY, True)
    assert 0.2 < event.delay < 0.9  # it is told once it is sure that it is not 0.2 s or less
    assert beliefs[-1].offsets.mean[GUILTY, 4] == pytest.approx(0.6, abs=0.2)
    assert "camera of robot 1 suspected to be late" in str(event)
    assert "no proof" in str(event)
    (restart,) = [
        each for belief in beliefs for each in belief.events if isinstance(each, Restarted) and "late" in each.because
    ]
    assert restart.robot == GUILTY
    assert 0 <= restart.suspended_since == event.since <= 0.2 * begins
    assert all(not each.aside or each.robot != GUILTY for each in turned_in(beliefs[int(event.time / 0.2) :]))


@pytest.mark.parametrize("seed", range(3))
def test_whoever_has_believed_a_late_camera_lately_starts_over_with_its_robot(seed):
    beliefs = list(late_touring(world_of(seed), 120, (0, np.inf)))
    (place,) = [k for k, belief in enumerate(beliefs) if told([belief])]
    before, now = beliefs[place - 1], beliefs[place]
    by_it = before.votes.accepted[:, before.votes.accepted.shape[1] - 3 + GUILTY]
    believers = set(np.flatnonzero(by_it > now.time - Rules().window).tolist()) - {GUILTY}
    restarted = {each.robot for each in now.events if isinstance(each, Restarted) and each.because == "it was misled"}
    assert believers
    assert believers <= restarted


@pytest.mark.parametrize("seed", range(2))
def test_a_camera_that_is_on_time_is_never_late(seed):
    world = world_of(seed, errors="extreme")
    for belief in late_touring(world, 400, (np.inf, np.inf)):
        assert told([belief]) == []
    assert np.abs(belief.offsets.mean[:, 4]).max() < 0.1


def test_a_camera_whose_clock_is_set_right_is_trusted_again():
    world = world_of(3)
    beliefs = list(late_touring(world, 800, (0, 250)))
    assert [event.aside for event in told(beliefs)] == [True, False]
    places, headings = inside(beliefs[-1], world)
    assert (places & headings).all()


@pytest.mark.parametrize(("seed", "robots"), [(0, 1), (1, 3)])
def test_a_late_camera_of_a_robot_that_was_carried_elsewhere_is_on_trial_and_found_to_be_right(seed, robots, monkeypatch):
    """Nothing is known of its heading then but what the camera itself says."""
    world, beliefs = world_of(seed, robots=robots), []
    for belief in late_touring(world, 800, (0, 350), carried=300, guilty=0):
        beliefs.append(belief)
        if belief.guarantee.in_force[0] and (len(beliefs) > 320 or (robots == 1 and told(beliefs))):
            assert 0 not in missing(belief, world)
    trial = [belief for belief in beliefs if belief.offsets.on_trial[0]]
    assert trial
    assert not any(belief.guarantee.in_force[0] and belief.regions[0].outer.area < 100 for belief in trial)
    assert not belief.offsets.late[0]
    assert belief.regions[0].outer.area < 1.0
