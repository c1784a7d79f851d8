"""Proves a run's certificates again, in exact rational arithmetic, with nothing but Python's standard library.

    python -m experiments.prove FOLDER

reads FOLDER/certificates.jsonl.gz (see docs/soundness.md). Each line claims: for every x with lower <= x <= upper that
satisfies the rows, normal . (x_robot - x_from) <= offset, or of x_robot alone where `from` is -1. With the line's multipliers
y >= 0 of the rows A x <= b, and c the normal in the robots' coordinates,
c.x = (c - A'y).x + y.(A x) <= max over the box of (c - A'y).x + y.b; the claim is proved if that is no greater than its
offset. Then each step is tied to what came before it: see `experiments.proof.chain`.

Exit code: 0 if everything is proved, 1 at the first line or link that is not, 2 if there is no such file, 3 if the verdict
cannot be written.
"""

import argparse
import gzip
import json
import os
import sys
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any, TextIO

from experiments.proof.chain import WORLD, Broken, Chain, exact

FILE = "certificates.jsonl.gz"
VERSION = 1  # of the format that is read
BAR = 40  # characters


def greatest(line: dict[str, Any]) -> Fraction:
    """Return what the line's multipliers prove to be above normal . (x_robot - x_from).

    Raises:
        Broken: A multiplier is negative, the box is empty, or a pair is none.
    """
    for i, j in ((line["from"], line["robot"]), *((row["i"], row["j"]) for row in line["rows"])):
        if not WORLD <= i < j:
            raise Broken(f"a pair {i}, {j} that is none, or in the wrong order")
    rest = {(line["robot"], k): exact(value) for k, value in enumerate(line["normal"])}
    if line["from"] != WORLD:
        rest |= {(line["from"], k): -exact(value) for k, value in enumerate(line["normal"])}
    total = Fraction(0)
    for row in line["rows"]:
        multiplier = exact(row["multiplier"])
        if multiplier < 0:
            raise Broken("a negative multiplier")
        total += multiplier * exact(row["offset"])
        for body, sign in ((row["j"], 1), (row["i"], -1)):
            for k, value in enumerate(row["normal"]) if body >= 0 else ():
                rest[body, k] = rest.get((body, k), Fraction(0)) - sign * multiplier * exact(value)
    for (body, k), value in rest.items():
        lower, upper = exact(line["lower"][str(body)][k]), exact(line["upper"][str(body)][k])
        if lower > upper:
            raise Broken("a box without a point")
        total += value * (upper if value > 0 else lower)
    return total


def check(line: dict[str, Any]) -> None:
    """Raise `Broken` unless the line proves its claim."""
    if line["version"] != VERSION:
        raise Broken(f"a certificate of version {line['version']}, where version {VERSION} is read")
    excess = greatest(line) - exact(line["offset"])
    if excess > 0:
        raise Broken(f"its rows prove an offset that is greater by {float(excess):.3g} m")


def lines(path: Path, out: TextIO) -> Iterator[dict[str, Any]]:
    """Yield the lines of a compressed file, with a progress bar."""
    size, shown = path.stat().st_size, -1
    with path.open("rb") as packed, gzip.open(packed, "rt", encoding="utf-8") as file:
        for text in file:
            yield json.loads(text)
            done = BAR * packed.tell() // max(size, 1)
            if done != shown:
                shown = done
                _show(out, f"\r[{'#' * done}{'.' * (BAR - done)}]")
    _show(out, "\n")


def _show(out: TextIO, text: str) -> None:
    with suppress(OSError):  # nobody looks
        out.write(text)
        out.flush()


def steps(found: Iterator[dict[str, Any]], count: list[int]) -> Iterator[list[dict[str, Any]]]:
    """Yield the lines of each step, every one of them proved in itself; count them.

    Raises:
        Broken: A line does not prove its claim.
    """
    step: list[dict[str, Any]] = []
    for line in found:
        count[0] += 1
        try:
            check(line)
            time = float.fromhex(line["t"])
        except (Broken, KeyError, IndexError, TypeError, ValueError, OverflowError) as error:
            when = " ".join(f"{name} = {line[name]}" for name in ("t", "robot") if isinstance(line, dict) and name in line)
            raise Broken(f"line {count[0]} ({when or 'of no time'}): {error}") from None
        if step and time != float.fromhex(step[0]["t"]):
            yield step
            step = []
        step.append(line)
    if step:
        yield step


def prove(folder: Path, out: TextIO) -> tuple[int, Chain]:
    """Prove a folder's certificates; return how many there are, and what is known of the links between the steps.

    Raises:
        Broken: Something is not proved.
        OSError: There is no such file.
    """
    chain, count = Chain(folder), [0]
    for step in steps(lines(folder / FILE, out), count):
        chain.check(step)
    if not count[0]:
        raise Broken("there is no certificate in the file")
    return count[0], chain


def main(arguments: Sequence[str] | None = None) -> int:
    """Prove the certificates in the folder that the command line names; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m experiments.prove", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="a folder with certificates.jsonl.gz, from a run with --certificates")
    folder = parser.parse_args(arguments).folder
    try:
        code, verdict = judged(folder)
        sys.stdout.write(verdict + "\n")
        sys.stdout.flush()
    except OSError as error:
        if error.filename:  # it is the file that is read
            sys.stderr.write(f"error: {error.filename}: {error.strerror}\n")
            return 2
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python fails at its end on what waits there
        with suppress(OSError):
            sys.stderr.write(f"error: the verdict cannot be written: {error.strerror}\n")
        return 3
    return code


def judged(folder: Path) -> tuple[int, str]:
    """Return the exit code and the verdict on a folder's certificates.

    Raises:
        OSError: There is no such file.
    """
    try:
        count, chain = prove(folder, sys.stderr)
    except Broken as error:
        return 1, f"not proved: {error}"
    except (EOFError, zlib.error, gzip.BadGzipFile, json.JSONDecodeError, UnicodeDecodeError) as error:
        return 1, f"not proved: the file is damaged: {error}"
    return 0, "\n".join([*chain.report(), f"{count} certificates proved, 0 failed"])


if __name__ == "__main__":
    sys.exit(main())
