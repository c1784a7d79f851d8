"""The simplex method on small programs, compiled: a basis that walks from vertex to vertex of {z : G z <= h, |z| <= 1}.

A vertex is where as many rows as there are variables hold with equality; these rows are its basis. Everything here is a
candidate: what the walk finds is for `certified` to judge, so rounding can cost tightness and nothing else.
"""

from typing import Any, NamedTuple

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.compiled import compiled, place_of_least

# Rows are moved outward by up to twice this [share of the box], each by another amount, so that no two vertices coincide.
OUTWARD = 1e-10
# A row is violated beyond this, far below what it was moved by.
VIOLATED = 1e-12
# A row that changes by less along an edge does not bound it.
PARALLEL = 1e-11
# After so many exchanges the inverse is mended.
MENDED_AFTER = 32

FOUND, EMPTY, LOST = 0, 1, 2  # how a walk ends


@compiled
def spread(k: Any) -> Any:
    """Return a number in [0, 1) for each whole number k, evenly spread, no two alike: multiples of the golden ratio."""
    return (k * 0.6180339887498949) % 1.0


class Rows(NamedTuple):
    """The rows of a program, the bounds of the variables last: z_j <= 1, then -z_j <= 1.

    A row has at most four non-zeros: two coordinates of two robots.

    Attributes:
        column: (r, 4) which variables; padded with 0.
        value: (r, 4) their coefficients; padded with 0.
        offset: (r,) moved outward a little.
    """

    column: Integers
    value: Array
    offset: Array


class Basis(NamedTuple):
    """A vertex and the rows that make it; changed in place.

    Attributes:
        inverse: (v, v) of the matrix of the basic rows; its column k, negated, is the edge on which row k is left.
        basic: (v,) the rows.
        is_basic: (r,) whether a row is among them.
        point: (v,) the vertex.
        slack: (r,) how far each row is from holding with equality; negative where it is violated.
    """

    inverse: Array
    basic: Integers
    is_basic: Mask
    point: Array
    slack: Array


@compiled
def corner(rows: Rows, objective: Array) -> Basis:
    """Return the corner of the box that is farthest in a direction; it need not satisfy the other rows."""
    variables = len(objective)
    bounds = len(rows.offset) - 2 * variables
    inverse, basic = np.zeros((variables, variables)), np.empty(variables, dtype=np.int64)
    is_basic = np.zeros(len(rows.offset), dtype=np.bool_)
    for j in range(variables):
        upper = objective[j] >= 0
        inverse[j, j] = 1.0 if upper else -1.0
        basic[j] = bounds + j if upper else bounds + variables + j
        is_basic[basic[j]] = True
    basis = Basis(inverse, basic, is_basic, np.empty(variables), np.empty(len(rows.offset)))
    locate(rows, basis)
    return basis


@compiled
def locate(rows: Rows, basis: Basis) -> None:
    """Compute the point and the slacks afresh."""
    variables = len(basis.basic)
    for j in range(variables):
        basis.point[j] = 0.0
        for k in range(variables):
            basis.point[j] += basis.inverse[j, k] * rows.offset[basis.basic[k]]
    for i in range(len(rows.offset)):
        basis.slack[i] = rows.offset[i] - along(rows, i, basis.point)
    for k in range(variables):
        basis.slack[basis.basic[k]] = 0.0


@compiled
def along(rows: Rows, i: int, vector: Array) -> float:
    """Return row i times a vector."""
    total = 0.0
    for q in range(4):
        total += rows.value[i, q] * vector[rows.column[i, q]]
    return total


@compiled
def combination(rows: Rows, basis: Basis, i: int, weights: Array) -> None:
    """Write row i as a combination of the basic rows."""
    weights[:] = 0.0
    for q in range(4):
        value, j = rows.value[i, q], rows.column[i, q]
        if value != 0.0:
            for k in range(len(weights)):
                weights[k] += value * basis.inverse[j, k]


@compiled
def slack_rates(rows: Rows, basis: Basis, k: int, rates: Array) -> None:
    """Write how fast each slack shrinks along the edge on which row k is left."""
    variables, edge = len(basis.point), -basis.inverse[:, k]
    bounds = len(rows.offset) - 2 * variables
    for i in range(bounds):
        rates[i] = along(rows, i, edge)
    for j in range(variables):
        rates[bounds + j], rates[bounds + variables + j] = edge[j], -edge[j]


@compiled
def exchange(basis: Basis, k: int, step: float, rates: Array, entering: int, weights: Array) -> None:
    """Leave the k-th basic row along its edge, a step far, and put another one in its place, a combination of the basic ones.

    The slacks shrink at the given rates along the edge.
    """
    variables, part = len(basis.basic), 1 / weights[k]
    for i in range(len(rates)):
        basis.slack[i] -= step * rates[i]
    for j in range(variables):
        basis.point[j] -= step * basis.inverse[j, k]
        share = basis.inverse[j, k] * part
        if share != 0.0:
            for m in range(variables):
                basis.inverse[j, m] -= share * weights[m]
            basis.inverse[j, k] = share
    basis.is_basic[basis.basic[k]] = False
    basis.is_basic[entering] = True
    basis.basic[k] = entering
    basis.slack[entering] = 0.0


@compiled
def reprice(prices: Array, k: int, weights: Array) -> None:
    """Change the weights of the basic rows in an objective accordingly."""
    share = prices[k] / weights[k]
    for m in range(len(weights)):
        prices[m] -= share * weights[m]
    prices[k] = share


@compiled
def mend(rows: Rows, basis: Basis) -> None:
    """Take the rounding of many exchanges out of the inverse, by a step of Newton's method (Schulz, 1933), and of the point."""
    variables = len(basis.basic)
    product = np.empty((variables, variables))
    for k in range(variables):
        combination(rows, basis, basis.basic[k], product[k])
        product[k, k] -= 1.0
    error = np.zeros(variables)
    for j in range(variables):
        error[:] = 0.0
        for k in range(variables):
            if basis.inverse[j, k] != 0.0:
                for m in range(variables):
                    error[m] += basis.inverse[j, k] * product[k, m]
        for m in range(variables):
            basis.inverse[j, m] -= error[m]
    locate(rows, basis)


@compiled
def become_feasible(rows: Rows, basis: Basis, prices: Array, limit: int) -> tuple[int, int]:
    """Walk, by the dual simplex method, from a basis with prices >= 0 to one whose vertex satisfies every row.

    Returns:
        FOUND; or EMPTY with the row that contradicts the basic ones; or LOST after too many exchanges.
    """
    weights, rates = np.empty(len(prices)), np.empty(len(rows.offset))
    for count in range(limit):
        entering = place_of_least(basis.slack)
        if basis.slack[entering] >= -VIOLATED:
            return FOUND, -1
        combination(rows, basis, entering, weights)
        k = none = len(prices)
        for m in range(len(prices)):
            if weights[m] > PARALLEL and (k == none or prices[m] * weights[k] < prices[k] * weights[m]):
                k = m
        if k == none:
            return EMPTY, entering
        reprice(prices, k, weights)
        for m in range(len(prices)):
            prices[m] = max(0.0, prices[m])
        slack_rates(rows, basis, k, rates)
        exchange(basis, k, -basis.slack[entering] / weights[k], rates, entering, weights)
        if (count + 1) % MENDED_AFTER == 0:
            mend(rows, basis)
    return LOST, -1
