"""Something is computed in a process of its own, with its own peak of memory; no process is left behind."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, TypeVar

from experiments.sweep.results import WorkerLost

Argument = TypeVar("Argument")
Told = TypeVar("Told")
# Linux tells a process's own peak here. What getrusage says there is no less than its parent's memory when it was made.
STATUS = Path("/proc/self/status")
# What getrusage counts in: kibibytes, but for macOS.
MEMORY_UNIT = 1 if sys.platform == "darwin" else 1024
MEBIBYTE = 2**20
# Linear algebra reads how many threads it may have as it is loaded. With several, small products wait for one another on a busy
# machine: what is mostly products, as a Kalman filter is, then seems many times slower than it is.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1")


@contextmanager
def one_thread() -> Iterator[None]:
    """Let the linear algebra of processes that are started within have one thread: times compare, sums keep their order."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ |= ONE_THREAD
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def in_own_process(generator: Callable[[Argument], Iterator[Told]], argument: Argument) -> Iterator[Told]:
    """Yield what a generator yields that runs in a new process, its linear algebra in one thread; it ends with this one.

    Args:
        generator: A function of a module, as the process imports it; what it yields is pickled.
        argument: What it is called with.

    Raises:
        WorkerLost: The process ended before the generator did.
    """
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_tell, args=(generator, argument, there), daemon=True)
    with one_thread():
        process.start()
    there.close()
    try:
        yield from _told(here)
    finally:
        here.close()
        process.kill()
        process.join()


def _told(here: Connection) -> Iterator[Any]:
    try:
        while (told := here.recv()) is not None:
            yield told[0]
    except EOFError:
        raise WorkerLost("a process ended before its work: killed, or out of memory") from None


def end_with_parent() -> None:
    """Let this process end as soon as the one that has made it is gone, killed or not, and at once at Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


def _tell(generator: Callable[[Any], Iterator[Any]], argument: Any, there: Connection) -> None:
    end_with_parent()
    for told in generator(argument):
        there.send((told,))
    there.send(None)


def peak_memory_mib() -> float | None:
    """Return the most memory that this process has had so far [MiB], or None where nobody knows."""
    if STATUS.exists():
        peak = re.search(r"VmHWM:\s*(\d+) kB", STATUS.read_text(encoding="ascii", errors="replace"))
        return round(int(peak[1]) * 1024 / MEBIBYTE, 1) if peak else None
    try:
        import resource  # noqa: PLC0415 - there is none on Windows
    except ImportError:
        return None
    return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * MEMORY_UNIT / MEBIBYTE, 1)
