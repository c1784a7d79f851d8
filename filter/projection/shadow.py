"""The exact projection onto a plane, by turning the direction: the shadow-vertex method (Gass and Saaty, 1955).

As the direction turns, the vertex that is farthest in it changes only when one of its prices reaches zero; then the walk
goes along one edge, whose shadow is an edge of the projection. So each edge of the projection costs one exchange of the
simplex method, where the paper thinks the exact projection out of reach (section 7).
"""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.convex import SMALLEST, area_of
from filter.geometry.simplify import edges_worth_keeping
from filter.projection.simplex import (
    FOUND,
    LOST,
    MENDED_AFTER,
    PARALLEL,
    Basis,
    Rows,
    combination,
    exchange,
    mend,
    reprice,
    slack_rates,
)

# A shadow with more edges than this is left to the search, and so is a walk of so many exchanges for each variable.
LONGEST, LONGEST_EACH = 400, 50
# A vertex that violates a row by more than this share of the box shows that the walk has strayed.
STRAYED = 1e-8
# Edges whose normals turn by less are one.
SAME = 1e-13
# What decides how many edges are kept: places in `REASONS`.
EXACTLY, BY_RATIO, BY_GAP, BY_SEARCHES = 0, 1, 2, 3
# Edges that together add less than this share of the allowance are rounding.
NEGLIGIBLE_SHARE_OF_AREA = 1e-6
# An edge whose shadow is shorter than this share of the plane's unit has none.
NO_SHADOW = 1e-8


class Trace(NamedTuple):
    """What a turn has seen: one entry for each edge of the shadow, and for directions between edges far apart.

    Attributes:
        normal: (t, 2) outward, of length 1.
        prices: (t, v) the weights of the rows `basic` whose combination is the normal.
        basic: (t, v) rows.
        point: (t, v) the vertex where the edge ends.
        filled: (1,) how many entries are filled.
    """

    normal: Array
    prices: Array
    basic: Integers
    point: Array
    filled: Integers


@compiled
def no_trace(length: int, variables: int) -> Trace:
    """Return a trace with room for so many entries."""
    basic, point = np.empty((length, variables), dtype=np.int64), np.empty((length, variables))
    return Trace(np.empty((length, 2)), np.empty_like(point), basic, point, np.zeros(1, dtype=np.int64))


@compiled
def turn(rows: Rows, basis: Basis, first: Array, second: Array, angle: float, trace: Trace, limit: int) -> int:
    """Turn the objective (v,) from `first`, through an angle [rad], keeping the basis optimal; return FOUND or LOST.

    A right angle ends at the objective `second`. Exchanges are limited in number; the trace is filled as far as it has room.
    """
    across, up = np.empty(len(first)), np.empty(len(first))  # prices for the plane's two axes
    price(first, basis, across)
    price(second, basis, up)
    weights, rates = np.empty(len(first)), np.empty(len(rows.offset))
    x, y, turned = 1.0, 0.0, 0.0
    _keep(trace, basis, across, up, x, y)
    for count in range(limit):
        k = _next_to_leave(across, up, x, y)
        left = angle - turned
        until = left if k < 0 else np.arctan2(max(0.0, x * across[k] + y * up[k]), y * across[k] - x * up[k])
        _keep_between(trace, basis, across, up, x, y, min(until, left))
        if until >= left:
            return LOST if _strayed(basis) else FOUND
        turned += until
        length = np.hypot(across[k], up[k])
        x, y = -up[k] / length, across[k] / length
        slack_rates(rows, basis, k, rates)
        entering = _first_to_block(basis, rates)
        if entering < 0:
            return LOST
        combination(rows, basis, entering, weights)
        exchange(basis, k, max(0.0, basis.slack[entering]) / rates[entering], rates, entering, weights)
        reprice(across, k, weights)
        reprice(up, k, weights)
        if (count + 1) % MENDED_AFTER == 0:
            mend(rows, basis)
            price(first, basis, across)
            price(second, basis, up)
        _keep(trace, basis, across, up, x, y)
    return LOST


@compiled
def price(objective: Array, basis: Basis, prices: Array) -> None:
    """Write the weights of the basic rows whose combination is an objective (v,)."""
    for k in range(len(prices)):
        prices[k] = 0.0
    for j in range(len(prices)):
        if objective[j] != 0.0:
            for k in range(len(prices)):
                prices[k] += objective[j] * basis.inverse[j, k]


@compiled
def _next_to_leave(across: Array, up: Array, x: float, y: float) -> int:
    """Return which price is the first to reach zero as the direction turns on; negative when none ever does."""
    chosen, best_rate, best_price = -1, 0.0, 1.0
    for k in range(len(across)):
        if abs(across[k]) + abs(up[k]) > NO_SHADOW:
            price = max(x * across[k] + y * up[k], 1e-290)
            rate = y * across[k] - x * up[k]  # how fast it falls
            if chosen < 0 or rate * best_price > best_rate * price:
                chosen, best_rate, best_price = k, rate, price
    return chosen


@compiled
def _first_to_block(basis: Basis, rates: Array) -> int:
    """Return the row that is met first; of rows met at the same place, the steepest. Negative when lost: there is none."""
    chosen, least, steepest = -1, 1.0, 0.0
    for i in range(len(rates)):
        rate = rates[i]
        if rate > PARALLEL:
            slack = max(0.0, basis.slack[i])
            difference = slack * steepest - least * rate
            if (difference < 0 or (difference == 0 and rate > steepest)) and not basis.is_basic[i]:
                chosen, least, steepest = i, slack, rate
    return -1 if _strayed(basis) else chosen


@compiled
def _strayed(basis: Basis) -> bool:
    """Return whether the vertex violates a row, or is none any more: a bound from there would be right, but far off."""
    strayed = False
    for slack in basis.slack:
        strayed |= not slack >= -STRAYED  # nor is it a number, then
    return strayed


@compiled
def _keep(trace: Trace, basis: Basis, across: Array, up: Array, x: float, y: float) -> None:
    at = trace.filled[0]
    if at < len(trace.normal):
        trace.normal[at, 0], trace.normal[at, 1] = x, y
        for k in range(len(across)):
            trace.prices[at, k] = x * across[k] + y * up[k]
            trace.basic[at, k], trace.point[at, k] = basis.basic[k], basis.point[k]
        trace.filled[0] = at + 1


@compiled
def _keep_between(trace: Trace, basis: Basis, across: Array, up: Array, x: float, y: float, until: float) -> None:
    """Keep directions between two edges, so that no two neighbours are more than a right angle apart."""
    pieces = int(np.ceil(until / (np.pi / 2) - 1e-9))
    for piece in range(1, pieces):
        cosine, sine = np.cos(until * piece / pieces), np.sin(until * piece / pieces)
        _keep(trace, basis, across, up, x * cosine - y * sine, x * sine + y * cosine)


@compiled
def simplified(normals: Array, vertices: Array, unit: float, goal: tuple[float, float, int]) -> tuple[Integers, int]:
    """Return the edges to keep of a shadow, for it to grow by little, and what decided, a place in `REASONS`.

    An edge has a normal (t, 2) and ends at a vertex (t, 2); an area of 1 stands for a unit [m2]; the goal is that of `Stop`.
    """
    count, some = len(normals), 0
    distinct, x, y = np.empty(count, dtype=np.int64), 0.0, 0.0
    for k in range(count):
        following = (k + 1) % count
        x, y = x + vertices[k, 0] / count, y + vertices[k, 1] / count
        turned = normals[k, 0] * normals[following, 1] - normals[k, 1] * normals[following, 0]
        if abs(turned) > SAME or normals[k, 0] * normals[following, 0] + normals[k, 1] * normals[following, 1] < 0:
            distinct[some] = k
            some += 1
    lines, offsets = np.empty((some, 2)), np.empty(some)
    for at in range(some):
        k = distinct[at]
        lines[at, 0], lines[at, 1] = normals[k, 0], normals[k, 1]
        offsets[at] = normals[k, 0] * (vertices[k, 0] - x) + normals[k, 1] * (vertices[k, 1] - y)
    ratio, gap, budget = goal
    by_ratio, by_gap = area_of(vertices) * (1 / max(ratio, SMALLEST) - 1), gap / max(unit, SMALLEST)
    keep, spent = edges_worth_keeping(lines, offsets, np.ones(some, dtype=np.bool_), budget, max(by_ratio, by_gap))
    why = BY_RATIO if by_ratio >= by_gap else BY_GAP
    if spent > max(by_ratio, by_gap):
        why = BY_SEARCHES
    elif spent <= NEGLIGIBLE_SHARE_OF_AREA * by_ratio:
        why = EXACTLY
    return distinct[:some][keep], why
