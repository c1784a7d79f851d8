"""The nearest right word for a wrong one."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def nearest(word: str, words: Iterable[str], shown: int = 12) -> str:
    """Return what to say of a word that is none of some words: the nearest one, or some of them."""
    known = sorted(set(words))
    close = get_close_matches(word, known, n=1, cutoff=0.5)
    if close:
        return f'did you mean "{close[0]}"?'
    more = f" and {len(known) - shown} more" if len(known) > shown else ""
    return f"there are {', '.join(known[:shown])}{more}" if known else "there is none"
