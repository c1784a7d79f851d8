"""Timing that others on the machine disturb little: by the process's own time, and things to compare in turn."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from time import process_time
from types import ModuleType
from typing import Any

import numpy as np


def medians(
    tasks: Iterable[Mapping[str, Callable[[], Any]]], repeats: Mapping[str, int], done: Callable[[], None] = lambda: None
) -> dict[str, float]:
    """Return the median time of each of some named things to do [s].

    They are done in turn in every round, so that a slow minute of the machine is slow for all of them.

    Args:
        tasks: A round each.
        repeats: How often a thing is done in a round, once if it is not named; the first time is not timed then, as it
            finds the caches cold.
        done: Called after each round.
    """
    seconds: dict[str, list[float]] = defaultdict(list)
    for each in tasks:
        for name, task in each.items():
            if name in repeats:
                task()
            for _ in range(repeats.get(name, 1)):
                begin = process_time()
                task()
                seconds[name].append(process_time() - begin)
        done()
    return {name: float(np.median(values)) for name, values in seconds.items()}


@contextmanager
def clocked(owner: ModuleType | type, names: Iterable[str]) -> Iterator[list[float]]:
    """Yield a list to which every call of one of a module's or a class's functions adds the process's time that it took [s]."""
    spent: list[float] = []
    before = {name: getattr(owner, name) for name in names}
    for name, function in before.items():
        setattr(owner, name, _clocked(function, spent))
    try:
        yield spent
    finally:
        for name, function in before.items():
            setattr(owner, name, function)


def _clocked(function: Callable[..., Any], spent: list[float]) -> Callable[..., Any]:
    def called(*arguments: Any, **named: Any) -> Any:
        begin = process_time()
        try:
            return function(*arguments, **named)
        finally:
            spent.append(process_time() - begin)

    return called
