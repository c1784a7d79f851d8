"""What is tolerated: in words, who may lie, and what is left of what liars say."""

import numpy as np
import pytest

from filter import InvalidInput, Range, SetMembershipFilter, Suspect, Team, Tolerance


def test_who_never_measures_short_is_no_farther_than_measured():
    record = Range(1.0, [0, 0, 1], [2, 3, 2], [5.0, 1.0, 2.0], [0.1, 0.2, 0.3], [0.01, 0.0, 0.5])
    (left,) = Tolerance(lies="long").believed([Suspect("sighting", 0, 2)], (record,))
    (least, most), (least_before, most_before) = left.interval(), record.interval()
    assert (least == [0.0, *least_before[1:]]).all()
    assert (most >= most_before).all()
    assert most == pytest.approx(most_before)


def test_nothing_is_kept_in_a_tolerance_that_is_wrong():
    for wrong in (
        {"q": 0},
        {"window": 0.0},
        {"suspects": "markers"},
        {"suspects": ()},
        {"lies": "short"},
        {"suspects": 3},
        {"lies": np.zeros(2)},
    ):
        with pytest.raises(InvalidInput):
            Tolerance(**wrong)
    with pytest.raises(InvalidInput):
        SetMembershipFilter(Team(1), tolerance=1)
    with pytest.raises(InvalidInput, match="suspects that measure ranges"):
        Tolerance(suspects="compasses", lies="long")
    assert str(Tolerance(q=2)).startswith("if at most 2 of these are wrong within any 5 s")
    assert Tolerance(suspects=("compasses", "pairs")).suspects == ("pairs", "compasses")
