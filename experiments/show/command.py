"""What every experiment does between the command line and its exit code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import tyro

from experiments.show.terminal import tell
from filter import CorralError

Options = TypeVar("Options")


def command(
    name: str, options: type[Options], run: Callable[[Options], int], arguments: Sequence[str] | None, stopped: str
) -> int:
    """Run an experiment with command-line arguments; return its exit code, 2 for bad input, 130 for Ctrl-C.

    Args:
        name: Of the experiment's module.
        options: A dataclass whose fields are the options; its docstring is the help text.
        run: Returns the exit code; any `CorralError` it raises is told and means 2.
        arguments: Those of the command line if None.
        stopped: What to tell somebody who has stopped it.
    """
    chosen = tyro.cli(options, prog=f"python -m experiments.{name}", args=arguments, config=(tyro.conf.FlagCreatePairsOff,))
    try:
        return run(chosen)
    except CorralError as error:
        tell(f"error: {error}")
        return 2
    except KeyboardInterrupt:
        tell(f"stopped; {stopped}")
        return 130
