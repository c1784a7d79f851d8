"""Sensors that are contradicted again and again are put aside, the guilty one and no other; when they agree they come back."""

import numpy as np
import pytest

from filter.errors import InvalidInput
from filter.robust.trust import Suspicion, Trust

ROBOTS, BODIES = 4, 10


def judged(wrong, steps=30, period=2.0, trust=None, seed=0):
    """Return the trust after steps in which each robot sees two bodies; `wrong` says of a pair whether it is contradicted."""
    rng = np.random.default_rng(seed)
    trust = trust or Trust.full(ROBOTS, BODIES, 0.0)
    start = trust.time
    for step in range(steps):
        seen = [(r, int(t)) for r in range(ROBOTS) for t in rng.choice([b for b in range(BODIES) if b != r], 2, replace=False)]
        trust = trust.judged(start + (step + 1) * period, [(r, t, bool(wrong(r, t))) for r, t in seen], Suspicion())
    return trust


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("camera", range(ROBOTS))
def test_a_camera_that_is_always_wrong_is_put_aside_and_nothing_else(camera, seed):
    trust = judged(lambda robot, _: robot == camera, seed=seed)
    assert np.flatnonzero(trust.camera).tolist() == [camera]
    assert not trust.identity.any()
    assert trust.aside(camera, 9)
    assert not trust.aside((camera + 1) % ROBOTS, 9)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("body", [0, 3, 7])
def test_an_identity_that_is_always_wrong_is_put_aside_and_nothing_else(body, seed):
    trust = judged(lambda _, target: target == body, seed=seed)
    assert np.flatnonzero(trust.identity).tolist() == [body]
    assert not trust.camera.any()


def test_one_error_in_ten_is_what_voting_is_for():
    rng = np.random.default_rng(1)
    trust = judged(lambda *_: rng.uniform() < 0.1, steps=100)
    assert not (trust.camera.any() or trust.identity.any())


def test_who_agrees_again_is_trusted_again():
    trust = judged(lambda robot, _: robot == 2)
    assert trust.camera[2]
    healed = judged(lambda *_: False, steps=60, trust=trust)
    assert not healed.camera.any()


def test_a_picture_every_blink_counts_no_more_than_one_in_a_while():
    """A wrong pair is one strike, and another one after each `repeat`."""
    trust, rules = Trust.full(ROBOTS, BODIES, 0.0), Suspicion()
    for step in range(1, 401):
        trust = trust.judged(step * 0.01, [(2, 7, True), (2, 8, True)], rules)
        strikes = 2 * (1 + (step - 1) * 0.01 / rules.repeat)
        assert trust.struck.sum() <= strikes + 1e-9
        assert trust.camera[2] == (trust.struck.sum() >= rules.strikes)
    assert trust.camera[2]


def test_one_bad_picture_is_one_whatever_is_in_it():
    trust, rules = Trust.full(ROBOTS, BODIES, 0.0), Suspicion()
    for instant in range(1, 4):
        assert not trust.camera.any()
        trust = trust.judged(instant * 1.6, [(2, body, True) for body in range(4, 10)], rules)
        trust = trust.judged(instant * 1.6 + 0.1, [(1, 9, False)], rules)
    assert np.flatnonzero(trust.camera).tolist() == [2]


def test_a_charge_is_as_old_as_the_first_contradiction_since_one_that_agreed():
    trust, rules = Trust.full(ROBOTS, BODIES, 0.0), Suspicion()
    for time, wrong in ((1.0, True), (2.0, False), (3.0, True), (4.0, True)):
        trust = trust.judged(time, [(2, 7, wrong), (1, 7, time > 3)], rules)
    assert trust.charges("identity", 7) == (3.0, (1, 2))
    assert trust.charges("camera", 1) == (4.0, (7,))
    assert trust.charges("camera", 0) == (np.inf, ())


@pytest.mark.parametrize("wrong", [{"memory": 0.0}, {"strikes": -1.0}, {"share": 2.0}, {"share": 0.0}, {"share": 1.0}])
def test_a_suspicion_out_of_range_is_refused(wrong):
    with pytest.raises(InvalidInput):
        Suspicion(**wrong)
