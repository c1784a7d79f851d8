"""Offsets that are proved from a few rows, compiled: the bound of `LinearProgram.certified_bounds`, for loops.

Of a pair i, j what is bounded is the position of j as seen from i, x_j - x_i, as in `Constraints`; of a robot j alone
i is WORLD.
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.convex import EPSILON
from filter.linear.constraints import Columns

Boxes = tuple[Array, Array]  # lower and upper corners (n, 2) of all robots
Members = tuple[Integers, Array, Array]  # the place of each robot (n,), centre and radius (v,) of the members' coordinates
# What underflow can take from some hundred products.
UNDERFLOW = 1e-300


@compiled
def middle_and_reach(low: float, high: float) -> tuple[float, float]:
    """Return the middle of an interval and how far it reaches from there, rounded up."""
    middle = (low + high) / 2
    reach = max(high - middle, middle - low)
    return middle, reach * (1 + 4 * EPSILON) if reach > 0 else 0.0


@compiled
def members_at(members: Integers, place: Integers, box: Boxes) -> Members:
    """Return where some robots are; their places among them are written into (n,) scratch."""
    centre, radius = np.empty(2 * len(members)), np.empty(2 * len(members))
    for k in range(len(members)):
        place[members[k]] = k
        for m in range(2):
            centre[2 * k + m], radius[2 * k + m] = middle_and_reach(box[0][members[k], m], box[1][members[k], m])
    return place, centre, radius


@compiled
def certified(i: int, j: int, normal: Array, prices: Array, number: Integers, members: Members, team: Columns) -> float:
    """Return an offset that holds in exact arithmetic for a direction of a robot's or a pair's position [m].

    Args:
        i: A member, or WORLD.
        j: A member.
        normal: (2,).
        prices: (p,) of the rows; those that are not above 0 and finite count nothing.
        number: (p,) which constraints; there is none beyond the last one.
        members: Where the members are.
        team: i, j, normal and offset of all constraints.
    """
    (place, centre, radius), (first, second, normals, offsets) = members, team
    residual, size = np.zeros(len(centre)), np.zeros(len(centre))
    total, doubt, operations = 0.0, 0.0, 2 * (len(number) + len(centre) + 8) * EPSILON
    along, reach = 0.0, 0.0
    for side in range(2):
        robot = j if side == 0 else i
        if robot >= 0:
            for m in range(2):
                at = 2 * place[robot] + m
                residual[at] = normal[m] if side == 0 else -normal[m]
                size[at] = abs(normal[m])
                along += residual[at] * centre[at]
                reach += abs(residual[at] * centre[at])
    for k in range(len(number)):
        row, price = number[k], prices[k]
        if row >= len(offsets) or not 0 < price < np.inf:
            continue
        slack, magnitude = offsets[row], abs(offsets[row])
        for side in range(2):
            robot = second[row] if side == 0 else first[row]
            if robot >= 0:
                for m in range(2):
                    coefficient = normals[row, m] if side == 0 else -normals[row, m]
                    at = 2 * place[robot] + m
                    slack -= coefficient * centre[at]
                    magnitude += abs(coefficient * centre[at])
                    residual[at] -= price * coefficient
                    size[at] += abs(price * coefficient)
        total += price * slack
        doubt += 16 * EPSILON * price * magnitude + operations * price * abs(slack)
    for at in range(len(centre)):
        total += abs(residual[at]) * radius[at]
        doubt += operations * size[at] * radius[at]
    doubt += 16 * EPSILON * (reach + abs(total))
    return (along + total) + doubt * (1 + 1e-9) + UNDERFLOW * (1 + radius.sum())
