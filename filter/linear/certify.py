"""Offsets that are proved from a few rows, compiled: the bound of `LinearProgram.certified_bounds`, for loops."""

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
def members_at(members: Integers, place: Integers, box: Boxes) -> Members:
    """Return where some robots are, radii rounded up; their places among them are written into (n,) scratch."""
    centre, radius = np.empty(2 * len(members)), np.empty(2 * len(members))
    for k in range(len(members)):
        place[members[k]] = k
        for m in range(2):
            low, high = box[0][members[k], m], box[1][members[k], m]
            middle = (low + high) / 2
            centre[2 * k + m] = middle
            radius[2 * k + m] = max(high - middle, middle - low) * (1 + 4 * EPSILON)
    return place, centre, radius


@compiled
def certified(i: int, j: int, normal: Array, prices: Array, number: Integers, members: Members, team: Columns) -> float:
    """Return an offset that holds in exact arithmetic for a direction of x_j - x_i, or of x_j where i is WORLD [m].

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
    for robot, sign in ((j, 1.0), (i, -1.0)):
        if robot >= 0:
            for m in range(2):
                at = 2 * place[robot] + m
                residual[at] = sign * normal[m]
                size[at] = abs(normal[m])
                along += residual[at] * centre[at]
                reach += abs(residual[at] * centre[at])
    for k in range(len(number)):
        row, price = number[k], prices[k]
        if row >= len(offsets) or not 0 < price < np.inf:
            continue
        slack, magnitude = offsets[row], abs(offsets[row])
        for robot, sign in ((second[row], 1.0), (first[row], -1.0)):
            if robot >= 0:
                for m in range(2):
                    at, coefficient = 2 * place[robot] + m, sign * normals[row, m]
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
