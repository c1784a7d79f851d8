"""A proof shared among processes, with the verdict of a single one. Standard library only.

Each process takes over all that is claimed, part by part, and proves some of the parts. What is claimed is the same whoever
proves it, so all of them know the same where a part begins; and whoever proves it does all that the others do besides. So a
single process would stop at the least part that any of several stops at, with the words of the one whose part that is.
"""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Callable
from errno import ECHILD
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any
from zlib import crc32

Job = Callable[["Share"], Counter[str]]
Outcome = tuple[int, Exception | None, Counter[str]]  # at which part it failed, why, and what was counted
END = 1 << 62  # a greater number than any part has


class OthersFailed(Exception):
    """What this process could still prove does not matter."""


class Share:
    """Which parts of a proof are this process's own.

    Attributes:
        number: Of the process, from 0 on.
        part: Number of the last part that has begun, -1 if none has.
    """

    def __init__(self, number: int = 0, processes: int = 1, failed: Any = None) -> None:
        """Take the number of one of so many processes, and where these note the least part that any has failed at."""
        self.number, self.part = number, -1
        self._processes, self._failed = processes, failed

    def has_next(self) -> bool:
        """Go on to the next part; return whether it is this process's own, or raise `OthersFailed` at an earlier one."""
        self.part += 1
        if self._failed is not None and self.part > self._failed.value:
            raise OthersFailed
        return whose(self.part, self._processes) == self.number


def whose(part: int, processes: int) -> int:
    """Return the number of the process that a part is for, in no order: heavy parts come in some."""
    return crc32(b"%d" % part) % processes


def shared(job: Job, processes: int) -> Counter[str]:
    """Return what a job counts, shared among so many processes, or raise what it raises; they end with this one.

    Raises:
        ChildProcessError: A process was ended by somebody else.
    """
    if processes == 1:
        return job(Share())
    context, ends, started = get_context("spawn"), list[Connection](), list[Any]()
    failed = context.Value("q", END)
    try:
        for number in range(processes):
            here, there = context.Pipe(duplex=False)
            started.append(context.Process(target=_work, args=(job, there, number, processes, failed), daemon=True))
            started[-1].start()
            there.close()
            ends.append(here)
        outcomes: list[Outcome] = [end.recv() for end in ends]
    except EOFError:
        raise ChildProcessError(ECHILD, "one of the processes was ended") from None
    finally:
        for process in started:
            process.kill()
            process.join()
    first, error, _ = min(outcomes, key=lambda outcome: outcome[0])
    if error is not None:
        raise outcomes[whose(first, processes)][1] or error
    return sum((counts for *_, counts in outcomes), Counter[str]())


def _work(job: Job, there: Connection, number: int, processes: int, failed: Any) -> None:
    """Do one process's share of a job, and send its outcome."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the one that started this one ends it
    share = Share(number, processes, failed)
    try:
        outcome: Outcome = END, None, job(share)
    except OthersFailed:
        outcome = END, None, Counter()
    except Exception as error:  # whatever it is, it is raised where the job was asked for
        outcome = share.part, error, Counter()
        with failed.get_lock():
            failed.value = min(failed.value, share.part)
    there.send(outcome)
