"""Compiles all that the filter has compiled, or loads it: the first run then need not wait for it. `make venv` does this.

Run `python -m experiments.warm_up --help`. Exit code 0.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

from experiments.show.command import command
from experiments.show.terminal import tell
from filter import warm_up


@dataclass(frozen=True)
class Options:
    """Compile all that the filter has compiled, once for this machine and this version, or load it. Exit code 0."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Compile with command-line arguments; return the exit code."""
    return command("warm_up", Options, run, arguments, stopped="what is compiled so far is kept")


def run(_: Options) -> int:
    """Compile or load; return the exit code."""
    begin = perf_counter()
    compiled = warm_up()
    tell(f"ready in {perf_counter() - begin:.1f} s; {compiled} functions compiled, the others were there")
    return 0


if __name__ == "__main__":
    sys.exit(main())
