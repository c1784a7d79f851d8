"""What an experiment shows in the terminal: a progress bar and messages on stderr, a table on stdout."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, as_completed
from contextlib import suppress
from types import TracebackType
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from experiments.following.metrics import Value

Result = TypeVar("Result")
WIDTH = 160  # of tables that no terminal shows, for a file or a pipe [characters]


class Terminal(Console):
    """Where something is shown; a pipe that is closed is an error on stdout, and nobody's loss on stderr."""

    def on_broken_pipe(self) -> None:
        """Go on in silence on stderr; on stdout raise what led here, where Rich would end the process."""
        if not self.stderr:
            raise  # noqa: PLE0704 - it is called while the error is handled
        self.quiet = True


def tell(message: str) -> None:
    """Print one message to stderr, if there is anybody to read it."""
    with suppress(OSError):
        Terminal(stderr=True).print(message, markup=False, highlight=False, soft_wrap=True)


def too_short(what: str, **counts: tuple[float, float]) -> bool:
    """Return whether a comparison rests on too little, and warn on stderr if so: it may say the opposite of a longer one.

    Args:
        what: What is compared.
        counts: For each kind of thing that it rests on, how many there were, and how many are enough.
    """
    few = [
        f"{things.replace('_', ' ')}: {came:g}, where {enough:g} are enough"
        for things, (came, enough) in counts.items()
        if came < enough
    ]
    if few:
        tell(f"warning: too short to compare ({'; '.join(few)}): {what} can come out the other way in longer runs")
    return bool(few)


def print_table(title: str, values: Mapping[str, Value], *, stderr: bool = False) -> None:
    """Print a table of names and values to stdout, or to stderr where stdout is for other things."""
    table = Table("quantity", "value", title=title, title_justify="left")
    table.columns[1].justify = "right"
    for name, value in values.items():
        table.add_row(name, "-" if value is None else str(value))
    show_table(table, stderr=stderr)


def show_table(table: Table, *, stderr: bool = False) -> None:
    """Print the table to stdout, or to stderr, folded to the terminal's width if that is one."""
    stream = sys.stderr if stderr else sys.stdout
    Terminal(width=None if stream.isatty() else WIDTH, stderr=stderr).print(table)


class StepProgress:
    """A progress bar over the steps of a run, with the run's time and how long a step takes. Use as a context manager."""

    def __init__(self, count: int | None) -> None:
        """Prepare the bar for `count` steps, or for nobody knows how many."""
        time, step = "{task.fields[time]:6.1f} s of the run", "{task.fields[step]:4.0f} ms a step"
        self._progress = Progress(
            BarColumn(), TextColumn(time), TextColumn(step), TimeRemainingColumn(), console=Terminal(stderr=True)
        )
        self._task = self._progress.add_task("", total=count, time=0.0, step=0.0)

    def advance(self, time: float, seconds: float) -> None:
        """Show that a step at `time` [s] of the run took `seconds`."""
        self._progress.update(self._task, advance=1, time=time, step=1e3 * seconds)

    def __enter__(self) -> StepProgress:
        self._progress.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._progress.stop()


class Counting:
    """A progress bar over things of one kind. Use as a context manager."""

    def __init__(self, count: int, things: str) -> None:
        """Prepare the bar for `count` things of which the name is a plural."""
        columns = (BarColumn(), MofNCompleteColumn(), TextColumn(things), TimeElapsedColumn(), TimeRemainingColumn())
        self._progress = Progress(*columns, console=Terminal(stderr=True))
        self._task = self._progress.add_task("", total=count)

    def advance(self) -> None:
        """Show that one more is done."""
        self._progress.advance(self._task)

    def __enter__(self) -> Counting:
        self._progress.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._progress.stop()


def gathered(futures: Sequence[Future[Result]], things: str) -> list[Result]:
    """Return the results in their order, with a progress bar while they are awaited; raise what the first to fail raised."""
    with Counting(len(futures), things) as progress:
        for future in as_completed(futures):
            future.result()
            progress.advance()
    return [future.result() for future in futures]
