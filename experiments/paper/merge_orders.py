"""The paper's static case, bearings only, merged in different orders: what depends on the order, and what does not.

Robots stand; one is anchored, and one coordinate of another, which fixes the scale. Each bearing is a record of its own. A
polytope is an intersection, so its regions are the same in any order; a Kalman filter linearises each bearing where the
ones before have moved its mean, so its estimate is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from experiments.following.metrics import rounded
from filter import Bearing
from filter.arrays import Array
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.ekf import ExtendedKalmanFilter, GaussianBelief
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.team import Team

ROBOTS = 6
SIZE = 6.0  # of the square that robots stand in [m]
APART = 1.2  # least distance between two robots [m]
REACH = 0.6  # half-width of the boxes that they are known to be in [m]
HEADING_BOUND = BEARING_BOUND = np.radians(3)
INSIDE = 1 - 1e-9  # errors keep their bounds when floats are rounded


@dataclass(frozen=True, eq=False)
class StaticCase:
    """A team that stands, and the bearings it measured.

    Attributes:
        positions: (n, 2) where the robots are [m].
        initial: (n) what is known of them.
        headings: (n) arcs around their headings.
        bearings: Every robot's bearing to every other, a record each.
    """

    positions: Array
    initial: tuple[Polygon, ...]
    headings: AngularIntervals
    bearings: tuple[Bearing, ...]


def static_case(generator: np.random.Generator) -> StaticCase:
    """Return a static case with errors uniform over their bounds."""
    positions = places(generator, ROBOTS, SIZE, APART)
    headings = generator.uniform(-np.pi, np.pi, ROBOTS)
    half = np.full((ROBOTS, 2), REACH)
    half[0], half[1, 0] = 0, 0
    centres = positions + half * INSIDE * generator.uniform(-1, 1, (ROBOTS, 2))
    known = wrap(headings + HEADING_BOUND * INSIDE * generator.uniform(-1, 1, ROBOTS))
    bearings = []
    for robot, target in zip(*np.nonzero(~np.eye(ROBOTS, dtype=bool)), strict=True):
        away = positions[target] - positions[robot]
        error = BEARING_BOUND * INSIDE * generator.uniform(-1, 1)
        measured = wrap(np.arctan2(away[1], away[0]) - headings[robot] + error)
        who, whom = np.array([robot]), np.array([target])
        bearings.append(Bearing(0.0, who, whom, np.atleast_1d(measured), np.array([BEARING_BOUND])))
    return StaticCase(
        positions,
        tuple(Polygon.box(centre - by, centre + by) for centre, by in zip(centres, half, strict=True)),
        AngularIntervals(known, np.full(ROBOTS, HEADING_BOUND)),
        tuple(bearings),
    )


def places(generator: np.random.Generator, count: int, size: float, apart: float) -> Array:
    """Return (count, 2) places uniform in a square [0, size]^2, at least so far apart [m]."""
    found: list[Array] = []
    while len(found) < count:
        place = generator.uniform(0, size, 2)
        if all(np.hypot(*(place - other)) >= apart for other in found):
            found.append(place)
    return np.array(found)


@dataclass(frozen=True)
class Spread:
    """How much results differ between the orders of one case.

    Attributes:
        set_area: Greatest less least area of an outer polygon, over its mean: the worst robot's.
        set_contains: Whether every outer polygon of every order contained its robot.
        ekf_position: Greatest distance between a robot's means of two orders [m].
        ekf_deviation: The same over the standard deviation that the filter gives that robot.
    """

    set_area: float
    set_contains: bool
    ekf_position: float
    ekf_deviation: float


def spread_over_orders(case: StaticCase, orders: int, generator: np.random.Generator) -> Spread:
    """Return how results differ between random orders of the same bearings."""
    team = Team(len(case.positions), speed_limit=0.0, turn_rate_limit=0.0)
    sets, kalman = SetMembershipFilter.light(team), ExtendedKalmanFilter(team)
    prior, guess = sets.start(0.0, case.initial, case.headings), kalman.start(0.0, case.initial, case.headings)
    free = [
        robot for robot, polygon in enumerate(case.initial) if np.ptp(polygon.vertices, axis=0).any()
    ]  # not anchored at a point
    wide = [robot for robot in free if case.initial[robot].area > 0]
    areas, contains, means, deviations = [], True, [], []
    for bearings in _shuffled(case.bearings, orders, generator):
        outers = [region.outer for region in sets.update(prior, bearings).regions]
        areas.append([outers[robot].area for robot in wide])
        contains &= all(bool(outer.contains(place)) for outer, place in zip(outers, case.positions, strict=True))
        estimate = kalman.update(guess, bearings)
        means.append(estimate.mean[free, :2])
        deviations.append(_deviations(estimate)[free])
    relative = np.ptp(areas, axis=0) / np.mean(areas, axis=0)
    between = np.array(means)[:, None] - np.array(means)
    widest = np.hypot(between[..., 0], between[..., 1]).max(axis=(0, 1))
    share = widest / np.mean(deviations, axis=0)
    return Spread(float(relative.max()), contains, float(widest.max()), float(share.max()))


def _shuffled(bearings: tuple[Bearing, ...], orders: int, generator: np.random.Generator) -> Iterator[tuple[Bearing, ...]]:
    for _ in range(orders):
        yield tuple(bearings[k] for k in generator.permutation(len(bearings)))


def _deviations(estimate: GaussianBelief) -> Array:
    return np.asarray(np.sqrt(np.trace(estimate.position_covariances, axis1=1, axis2=2)))


def compare_orders(seed: int, cases: int = 6, orders: int = 8) -> dict[str, float | int | bool]:
    """Return the worst and mean spreads of some random cases, as flat values."""
    generator = np.random.default_rng(seed)
    spreads = [spread_over_orders(static_case(generator), orders, generator) for _ in range(cases)]
    return {
        "order_cases": cases,
        "order_orders": orders,
        "order_set_containment": float(np.mean([spread.set_contains for spread in spreads])),
        "order_set_area_spread": float(f"{max(spread.set_area for spread in spreads):.1g}"),
        "order_ekf_position_spread_m": rounded(float(np.mean([spread.ekf_position for spread in spreads]))),
        "order_ekf_position_spread_max_m": rounded(max(spread.ekf_position for spread in spreads)),
        "order_ekf_position_spread_deviations": rounded(float(np.mean([spread.ekf_deviation for spread in spreads]))),
    }
