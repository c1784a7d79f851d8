"""Votes are merged as the relaxed intersection says: whoever may be wrong, all others have to agree."""

from functools import partial

import numpy as np
import pytest

from filter.errors import InvalidInput
from filter.geometry.polygon import Polygon
from filter.poses.slices import AGREED
from filter.robust.hypotheses import Hypotheses, reach_of
from filter.robust.slices import stay_within
from filter.robust.votes import Poll, Rules, Votes

HALF = 5.0
BODIES = 12


def interval(low, high):
    """Return a vote that says: x is between these."""
    return partial(stay_within, reach_of(Polygon.box([low, -HALF], [high, HALF])))


def poll(rules, time=0.0, sets=None, votes=None):
    anywhere = Hypotheses.agreed(reach_of(Polygon.box([-HALF, -HALF], [HALF, HALF])), 0.0, 0.01)
    return Poll(sets or (anywhere,), votes or Votes.none(1, BODIES, 0.0), time, rules, 72)


def extent(found):
    """Return the least and greatest x that is left."""
    right, left = found.hull()[0], -found.hull()[12]
    return left, right


def relaxed(votes, least=0):
    """Return the hull of what all votes agree on, or all but one of them from number `least` on; or None."""
    kept = [votes, *(votes[:k] + votes[k + 1 :] for k in range(least, len(votes)))]
    left = [(max([-HALF, *(low for low, _ in some)]), min([HALF, *(high for _, high in some)])) for some in kept]
    left = [(low, high) for low, high in left if low <= high]
    return (min(low for low, _ in left), max(high for _, high in left)) if left else None


@pytest.mark.parametrize("seed", range(20))
def test_all_votes_but_any_one_have_to_agree(seed):
    rng = np.random.default_rng(seed)
    asked, merged = poll(Rules()), []
    for column in range(1, 7):
        low = rng.uniform(-3, 1)
        vote = (low, low + rng.uniform(1, 4))
        verdict = asked.cast(0, column, interval(*vote))
        if relaxed([vote, *merged], least=1) is None:  # nothing agrees with it, whoever else may be wrong
            assert verdict == "rejected"
            assert extent(asked.sets[0]) == pytest.approx(relaxed(merged), abs=1e-9)
            continue
        merged.append(vote)
        assert extent(asked.sets[0]) == pytest.approx(relaxed(merged), abs=1e-9)
        if max(low for low, _ in merged) > min(high for _, high in merged):
            assert verdict == "contradicted"
            return
        assert verdict == "agreed"


def test_without_tolerance_all_have_to_agree():
    asked = poll(Rules(tolerated=0))
    assert [asked.cast(0, 1, interval(-1, 1)), asked.cast(0, 2, interval(0, 2))] == ["agreed", "agreed"]
    assert extent(asked.sets[0]) == pytest.approx((0, 1), abs=1e-9)
    assert asked.cast(0, 3, interval(2, 3)) == "rejected"
    assert extent(asked.sets[0]) == pytest.approx((0, 1), abs=1e-9)


def test_a_pair_that_says_it_again_has_one_vote():
    """However often a liar repeats it, what does without this one vote is left."""
    asked = poll(Rules())
    asked.cast(0, 1, interval(-1, 1))
    for _ in range(5):
        asked.cast(0, 2, interval(0.9, 3))
    assert extent(asked.sets[0]) == pytest.approx((-1, 3), abs=1e-9)  # either of the two may be wrong
    assert asked.cast(0, 3, interval(-2, 0.5)) == "contradicted"
    assert extent(asked.sets[0]) == pytest.approx((-1, 1), abs=1e-9)  # the second or the third


def test_a_window_ends_with_all_that_is_possible_agreed_on():
    first = poll(Rules(window=20.0, pause=1.5))
    first.cast(0, 1, interval(-1, 1))
    first.cast(0, 2, interval(0, 2))
    later = poll(Rules(window=20.0, pause=1.5), 19.0, tuple(first.sets), first.votes)
    later.expire(0)
    assert set(later.sets[0].without.tolist()) > {AGREED}
    over = poll(Rules(window=20.0, pause=1.5), 20.0, tuple(later.sets), later.votes)
    over.expire(0)
    assert set(over.sets[0].without.tolist()) == {AGREED}
    assert extent(over.sets[0]) == pytest.approx((-1, 2), abs=1e-9)


def test_who_is_contradicted_by_many_and_confirmed_by_few_is_lost():
    asked = poll(Rules(quorum=3))
    asked.cast(0, 1, interval(-1, 0))
    asked.cast(0, 2, interval(-1, 0))
    for column in (3, 4, 5):
        assert not asked.contested()[1][0]
        assert asked.cast(0, column, interval(3, 4)) == "rejected"
    assert asked.contested()[1][0]
    asked.restart(0, Hypotheses.agreed(reach_of(Polygon.box([-HALF, -HALF], [HALF, HALF]))))
    assert not asked.contested()[1][0]
    assert asked.cast(0, 3, interval(3, 4)) == "agreed"


def test_asking_whether_a_vote_agrees_merges_nothing():
    asked = poll(Rules())
    asked.cast(0, 1, interval(-1, 1))
    before = asked.sets[0]
    assert asked.agrees(0, interval(0, 5))
    assert not asked.agrees(0, interval(2, 5))
    assert asked.sets[0] is before


def test_who_believed_an_identity_had_a_vote_that_rests_on_it():
    asked = poll(Rules())
    asked.cast(0, 1, interval(-1, 1), whoever=True)
    assert asked.believed("camera", 0, BODIES, -1.0).tolist() == [True]
    assert asked.believed("identity", 1, BODIES, -1.0).tolist() == [False]
    asked.cast(0, 1, interval(-1, 1))
    assert asked.believed("identity", 1, BODIES, -1.0).tolist() == [True]
    asked.cast(0, 1, interval(-1, 1), whoever=True)
    assert asked.believed("identity", 1, BODIES, -1.0).tolist() == [True]  # what was believed before still is
    assert asked.believed("identity", 1, BODIES, 0.0).tolist() == [False]  # it was not after that


@pytest.mark.parametrize("wrong", [{"tolerated": 2}, {"window": -1.0}, {"memory": np.nan}, {"quorum": 0}])
def test_rules_out_of_range_are_refused(wrong):
    with pytest.raises(InvalidInput):
        Rules(**wrong)
