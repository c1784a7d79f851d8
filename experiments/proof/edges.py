"""Edges that were proved of a robot or a pair, and what two of them say together. Exact arithmetic, standard library only."""

from collections.abc import Iterator
from fractions import Fraction
from math import isfinite
from typing import Any

from experiments.proof.exact import Vector, Whole, nearly, whole
from experiments.proof.reading import Broken, exact

SIDES = (("upper", 0, (1, 0)), ("upper", 1, (0, 1)), ("lower", 0, (-1, 0)), ("lower", 1, (0, -1)))
WORLD = -1
MOST = 1000  # edges of one robot or pair in a step: any two of them may prove something
TRIED = 9  # pairs of edges: where some are almost parallel, floats err
ALMOST = 1e-9  # a normal that is parallel to an edge, but for so much, may be to either side of it

Edges = dict[tuple[int, int], dict[Vector, Fraction]]  # of each robot (WORLD, j) or pair i, j: offsets by normals


def plane(normal: Any) -> Vector:
    """Return a normal, of two numbers or two C99 hexadecimal strings, as exact numbers."""
    x, y = (exact(value) if isinstance(value, str) else Fraction(value) for value in normal)
    return x, y


def unit_normal(normal: Any) -> Vector:
    """Return a normal as exact numbers.

    Raises:
        Broken: Its length is not between 1/2 and 2: floats, which say what is worth a look, could be far off.
    """
    x, y = plane(normal)
    a, b, one = whole(x, y)
    if not one**2 <= 4 * (a**2 + b**2) <= 16 * one**2:
        raise Broken(f"a normal of length 1 was expected, not ({float(x):.6g}, {float(y):.6g})")
    return x, y


def add(edges: Edges, pair: tuple[int, int], normal: Vector, offset: Fraction) -> None:
    """Take in an edge of a robot or a pair; raises `Broken` if it has too many."""
    known = edges.setdefault(pair, {})
    known[normal] = min(offset, known.get(normal, offset))
    if len(known) > MOST:
        raise Broken(f"more than {MOST} edges of {pair} in one step")


def all_edges(proved: Edges, pair: tuple[int, int]) -> dict[Vector, Fraction]:
    """Return what was proved of a robot, or of a pair with what the two boxes say of it."""
    edges, (i, j) = dict(proved.get(pair, {})), pair
    for _, _, direction in SIDES if i != WORLD else ():
        normal, back = plane(direction), plane((-direction[0], -direction[1]))
        if normal in proved.get((WORLD, j), {}) and back in proved.get((WORLD, i), {}):
            side = proved[WORLD, j][normal] + proved[WORLD, i][back]
            edges[normal] = min(side, edges.get(normal, side))
    return edges


def through_corner(edges: dict[Vector, Fraction], normal: Vector, enough: Fraction | None = None) -> Fraction | None:
    """Return nearly the least offset in a direction that two edges prove, one to either side of it; None if no two do.

    Those that seem best to floats are tried, until one proves enough, or some have been.
    """
    found, first = [], _beside(edges, normal) if enough is not None else None
    if first and (bound := of_two(edges, *first, normal)) is not None and enough is not None and bound <= enough:
        return bound
    for _, a, b in sorted(_pairs(edges, normal), key=lambda pair: pair[0]):
        bound = of_two(edges, a, b, normal)
        if bound is not None:
            found.append(bound)
            if len(found) == TRIED or (enough is not None and bound <= enough):
                break
    return min(found, default=edges.get(normal))


def _beside(edges: dict[Vector, Fraction], normal: Vector) -> tuple[Vector, Vector] | None:
    """Return the edges whose normals are nearest to one, to either side, as nearly as floats tell; None if there are none."""
    (x, y), sides = nearly(*normal), (list[tuple[float, Vector]](), list[tuple[float, Vector]]())
    for edge in edges:
        p, q = nearly(*edge)
        turned = p * y - q * x
        if p * x + q * y > 0:
            sides[turned < 0].append((abs(turned), edge))
    return (min(sides[0])[1], min(sides[1])[1]) if all(sides) else None


def _pairs(edges: dict[Vector, Fraction], normal: Vector) -> Iterator[tuple[float, Vector, Vector]]:
    """Yield the offset that two edges prove, as nearly as floats tell, and these."""
    x, y = nearly(*normal)
    doubt = ALMOST * (abs(x) + abs(y))
    floats = [(edge, nearly(*edge, offset)) for edge, offset in edges.items()]
    for a, (ax, ay, of_a) in floats:
        by_b = ax * y - ay * x
        for b, (bx, by, of_b) in floats if by_b >= -doubt else ():
            turned, by_a = ax * by - ay * bx, x * by - y * bx
            if turned > 0 and by_a >= -doubt and isfinite(least := (by_a * of_a + by_b * of_b) / turned):
                yield least, a, b


def of_two(edges: dict[Vector, Fraction], a: Vector, b: Vector, normal: Vector) -> Fraction | None:
    """Return the offset that two edges prove in a direction between them, or None if it is not between them."""
    ax, ay, bx, by, x, y, of_a, of_b, unit_of = whole(*a, *b, *normal, edges[a], edges[b])
    turned, by_a, by_b = across((ax, ay), (bx, by)), across((x, y), (bx, by)), across((ax, ay), (x, y))
    return Fraction(by_a * of_a + by_b * of_b, turned * unit_of) if turned > 0 and min(by_a, by_b) >= 0 else None


def across(a: Whole, b: Whole) -> int:
    """Return the cross product of two vectors."""
    return a[0] * b[1] - a[1] * b[0]
