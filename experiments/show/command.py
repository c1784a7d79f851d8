"""What every experiment does between the command line and its exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TypeVar

import tyro

from experiments.show.terminal import tell
from filter import CorralError

Options = TypeVar("Options")

# Exit codes; 0, 1 and SUSPENDED are the experiment's own: its guarantee held, was broken, or was suspended for a while.
BAD_INPUT, CANNOT_WRITE, SUSPENDED, STOPPED = 2, 3, 4, 130


def command(
    name: str, options: type[Options], run: Callable[[Options], int], arguments: Sequence[str] | None, stopped: str
) -> int:
    """Run an experiment with command-line arguments; return its exit code.

    That is 2 for bad input, 3 for what cannot be written (a full disk, a closed pipe), 130 for Ctrl-C.

    Args:
        name: Of the experiment's module.
        options: A dataclass whose fields are the options; its docstring is the help text.
        run: Returns the exit code; any `CorralError` it raises is told and means 2, any `OSError` 3.
        arguments: Those of the command line if None.
        stopped: What to tell somebody who has stopped it.
    """
    try:
        return _flushed(lambda: run(_chosen(name, options, arguments)))
    except CorralError as error:
        tell(f"error: {error}")
        return BAD_INPUT
    except OSError as error:
        _leave_stdout()
        what = f"{error.filename}: " if error.filename else ""
        tell(f"error: {what}{error.strerror or error}; what could not be written is missing or not whole")
        return CANNOT_WRITE
    except KeyboardInterrupt:
        tell(f"stopped; {stopped}")
        return STOPPED


def _chosen(name: str, options: type[Options], arguments: Sequence[str] | None) -> Options:
    return tyro.cli(options, prog=f"python -m experiments.{name}", args=arguments, config=(tyro.conf.FlagCreatePairsOff,))


def _flushed(work: Callable[[], int]) -> int:
    """Return what the work returns; what waits for stdout may turn out not to be writable at the end, the help text too."""
    try:
        return work()
    finally:
        sys.stdout.flush()


def _leave_stdout() -> None:
    """Let nothing that still waits for stdout be written: Python would fail on it at its end, with a code of its own."""
    with suppress(OSError, ValueError):  # there may be no file behind it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
