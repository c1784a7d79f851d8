"""One line of certificates, proved in itself. Exact arithmetic, standard library only.

It claims: for every x with lower <= x <= upper that satisfies the rows, normal . (x_robot - x_from) <= offset, or of x_robot
alone where `from` is -1. With its multipliers y >= 0 of the rows A x <= b, and c the normal in the robots' coordinates,
c.x = (c - A'y).x + y.(A x) <= max over the box of (c - A'y).x + y.b; it is proved if that is no greater than its offset.
An `empty` line claims that there is no such x: with c = 0 that is below 0, or the box is empty.
"""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from experiments.proof.edges import WORLD, unit_normal
from experiments.proof.exact import whole
from experiments.proof.reading import Broken, Record, exact, shown


def check(line: Record) -> Fraction:
    """Return the offset that a line proves, which is its claim's or less.

    Raises:
        Broken: It is greater.
    """
    proved = greatest(line)
    if "empty" in line and proved >= 0:
        raise Broken("its rows do not exclude one another")
    excess = proved - exact(line["offset"])
    if excess > 0:
        raise Broken(f"its rows prove an offset that is greater by {float(excess):.3g} m")
    return proved


def greatest(line: Record) -> Fraction:
    """Return what the line's multipliers prove to be above normal . (x_robot - x_from).

    Raises:
        Broken: A multiplier is negative, the box is empty, or a pair is none.
    """
    for i, j in ((line["from"], line["robot"]), *((row["i"], row["j"]) for row in line["rows"])):
        if not (type(i) is type(j) is int and WORLD <= i < j):
            raise Broken(f"a pair {shown(i)}, {shown(j)} that is none, or in the wrong order")
    is_empty = "empty" in line
    if is_empty and (line["from"] != WORLD or any(map(exact, line["normal"]))):
        raise Broken("an empty line that is about something")
    for one in line["rows"] if is_empty else (line, *line["rows"]):
        unit_normal(one["normal"])
    (x, y, *values, unit_of), total = whole(*map(exact, _numbers(line))), Fraction(0)
    ends, of_rows = ((line["robot"], unit_of), (line["from"], -unit_of)), zip(*[iter(values)] * 4, strict=True)
    rest = {body: [sign * x, sign * y] for body, sign in ends if body != WORLD}
    for row, (multiplier, offset, *normal) in zip(line["rows"], of_rows, strict=True):
        if multiplier < 0:
            raise Broken("a negative multiplier")
        total += multiplier * offset
        for body, sign in ((row["j"], -1), (row["i"], 1)):
            for k, value in enumerate(normal) if body >= 0 else ():
                rest.setdefault(body, [0, 0])[k] += sign * multiplier * value
    for body, both in rest.items():
        for k, value in enumerate(both):
            lower, upper = exact(line["lower"][str(body)][k]), exact(line["upper"][str(body)][k])
            if lower > upper and is_empty:
                return Fraction(-1)
            if lower > upper:
                raise Broken("a box without a point")
            total += value * (upper if value > 0 else lower)
    return total / unit_of**2


def _numbers(line: Record) -> Iterator[Any]:
    """Yield a line's normal and, of each row, multiplier, offset and normal."""
    yield from line["normal"]
    for row in line["rows"]:
        yield from (row["multiplier"], row["offset"], *row["normal"])
