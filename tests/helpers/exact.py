"""What an alarm says, confirmed by fractions: nothing here rounds, and nothing of the filter's arithmetic is used."""

from fractions import Fraction


def exactly(values):
    return [Fraction(float(value)) for value in values]


def greatest(normals, offsets, direction):
    """Return the greatest direction . x over all x with normals x <= offsets, exact; None where nothing bounds it."""
    rows = [(*exactly(normal), Fraction(float(offset))) for normal, offset in zip(normals, offsets, strict=True)]
    u, v = exactly(direction)
    bounds = [_mixed(one, other, u, v) for one in rows for other in rows]
    return min((bound for bound in bounds if bound is not None), default=None)


def _mixed(one, other, u, v):
    """Return the bound that two rows with multipliers from 0 on prove, if their normals add up to (u, v) with any."""
    (a, b, p), (c, d, q) = one, other
    across = a * d - b * c
    if across == 0:
        return None
    first, second = (u * d - v * c) / across, (a * v - b * u) / across
    return first * p + second * q if first >= 0 and second >= 0 else None


def is_beyond(polygon, moved, normal, point):
    """Return whether a point is farther out, along a normal, than a polygon and so far more: a proof that it is not there."""
    bound, along = greatest(polygon.normals, polygon.offsets, normal), exactly(normal)
    beyond = sum(n * x for n, x in zip(along, exactly(point), strict=True)) - bound
    return beyond > 0 and beyond**2 > Fraction(float(moved)) ** 2 * sum(n * n for n in along)
