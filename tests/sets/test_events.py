"""What happened beside an update, in words."""

import pytest

from filter.projection.fallback import Fallback

WALK = ("walk",)


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (Fallback(1, WALK, "piqp"), "the region of robot 1: no good answer of walk, piqp took over"),
        (Fallback(None, ("piqp",), "highs"), "the deepest point: no good answer of piqp, highs took over"),
        (Fallback(2, ("walk", "piqp"), None), "the region of robot 2: no good answer of walk, piqp, nobody took over"),
        (Fallback(1, WALK, None, 0), "the region of robot 1 seen from robot 0: no good answer of walk, nobody took over"),
    ],
)
def test_a_fallback_says_what_failed_and_who_took_over(event, words):
    assert str(event) == words
