"""A sweep: many independent runs of one task, each with its own file, so that one which was killed goes on where it was.

A result's file is there as a whole or not at all. A fingerprint of all that decides the results lies beside them, so that
results of different options are never mixed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from experiments.show.output import write_whole
from filter import CorralError, InvalidInput

Case = TypeVar("Case")
Result = dict[str, Any]  # whatever JSON can hold

RESULTS = "runs"
FINGERPRINT = "options.json"


class WorkerLost(CorralError):
    """A worker died; what is finished is kept."""


@dataclass(frozen=True)
class Results:
    """The results of a sweep, one file a run.

    Attributes:
        folder: `options.json` is in it, and a folder `runs` with NAME.json for every finished run.
        fingerprint: All that decides a result but its case: a JSON object.
    """

    folder: Path
    fingerprint: Mapping[str, Any]

    def open(self, resume: bool) -> None:
        """Make the folder ready: a new one, or with `resume` one that a sweep with the same fingerprint has begun.

        Raises:
            InvalidInput: There are results already and they are not to be resumed, or they are of other options.
        """
        mine = json.dumps(self.fingerprint, indent=2, sort_keys=True) + "\n"
        path = self.folder / FINGERPRINT
        if any(self._runs.glob("*.json")):
            if not resume:
                raise InvalidInput("--resume to go on, or another --out to start anew", f"a sweep's results in {self._runs}")
            self._check(path, mine)
        try:
            self._runs.mkdir(parents=True, exist_ok=True)
            for left in self._runs.glob(".*.tmp"):
                left.unlink()
            write_whole(path, mine)
        except OSError as error:
            raise InvalidInput("an output folder that can be written to", f"{self.folder}: {error.strerror}") from None

    def read(self, name: str) -> Result | None:
        """Return a run's result, or None where there is none, or none that is whole."""
        try:
            result = json.loads(self._path(name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return result if isinstance(result, dict) else None

    def write(self, name: str, result: Result) -> None:
        """Keep a run's result: all of it or nothing, whenever the machine stops."""
        write_whole(self._path(name), json.dumps(result, allow_nan=False) + "\n")

    def _check(self, path: Path, mine: str) -> None:
        try:
            theirs = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            theirs = {}
        ours = json.loads(mine)
        differ = sorted(key for key in {*ours, *theirs} if ours.get(key) != theirs.get(key))
        if differ:
            came = ", ".join(f"{key} {theirs.get(key)}" for key in differ)
            wanted = ", ".join(f"{key} {ours.get(key)}" for key in differ)
            raise InvalidInput(f"results in {self.folder} of the same options ({wanted}), or another --out", came)

    def _path(self, name: str) -> Path:
        return self._runs / f"{name}.json"

    @property
    def _runs(self) -> Path:
        return self.folder / RESULTS


def carry_out(results: Results, pool: Executor, task: Callable[[Case], Result], cases: Mapping[str, Case]) -> Iterator[str]:
    """Compute and keep what is missing; yield the name of every case when its result is there, the old ones first.

    Args:
        results: Where results are kept; opened.
        pool: Computes.
        task: What is computed from a case; both must reach another process.
        cases: By the names of their results.

    Raises:
        WorkerLost: A process died.
        CorralError: What the task raises.
    """
    missing = [name for name in cases if results.read(name) is None]
    yield from (name for name in cases if name not in set(missing))
    futures: dict[Future[Result], str] = {}
    try:
        futures |= {pool.submit(task, cases[name]): name for name in missing}
        for future in as_completed(futures):
            name = futures.pop(future)  # let go of it: a large sweep keeps no results in memory
            results.write(name, future.result())
            yield name
    except (BrokenExecutor, CancelledError) as error:
        raise WorkerLost(f"a worker is lost ({error}); --resume goes on from what is finished") from None
    finally:
        for future in futures:
            future.cancel()
