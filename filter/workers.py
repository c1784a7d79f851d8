"""Work in threads of its own, which an exception that a signal's handler raises in the caller neither breaks nor blocks.

Such handlers (of Ctrl-C, of a watchdog) run in the main thread between any two instructions of Python. The pools of
`concurrent.futures` do not survive that: what is raised inside one of their locks leaves it locked for ever. Raw threads and
`SimpleQueue` are written in C, where no handler runs.
"""

import _thread
import atexit
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_AT_WORK: dict[int, Any] = {}  # by its number, each thread and the lock that it holds until it ends
os.register_at_fork(after_in_child=_AT_WORK.clear)


def spread(work: Callable[[Item], Result], items: Sequence[Item], threads: int) -> list[Result]:
    """Return the work on each of the items, in their order, done by so many threads at a time; the caller only waits.

    What it raises first is raised here; what is not begun then is not done. An interrupt leaves at once: the threads end by
    themselves, each after the item that it is at.
    """
    todo, done = SimpleQueue[tuple[int, Item]](), SimpleQueue[tuple[int, Any, BaseException | None]]()
    for numbered in enumerate(items):
        todo.put(numbered)
    results = dict[int, Result]()
    try:
        for _ in range(min(threads, len(items))):
            _thread.start_new_thread(_work_off, (work, todo, done))
        while len(results) < len(items):
            place, result, error = done.get()
            if error is not None:
                raise error
            results[place] = result
    finally:
        _drop(todo)
    return [results[place] for place in range(len(items))]


def _work_off(work: Callable[[Any], Any], todo: SimpleQueue[Any], done: SimpleQueue[Any]) -> None:
    thread, lock = _thread.get_ident(), _thread.allocate_lock()
    with lock, suppress(Empty):
        _AT_WORK[thread] = lock
        while True:
            place, item = todo.get_nowait()
            try:
                done.put((place, work(item), None))
            except BaseException as error:
                _drop(todo)
                done.put((place, None, error))
    del _AT_WORK[thread]


def _drop(todo: SimpleQueue[Any]) -> None:
    with suppress(Empty):
        while True:
            todo.get_nowait()


@atexit.register
def _let_end() -> None:
    """Let the threads end that an interrupt has left at work: the interpreter cannot end around them."""
    for lock in list(_AT_WORK.values()):
        lock.acquire()
