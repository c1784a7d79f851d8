"""How far the robots of a team that stands can be, at least: configurations that agree with all ranges, found by climbing.

The exact set of a team has two dimensions for each robot, and no simple border. But any configuration in which all ranges hold
is in it. Such ones are looked for as far as possible in many directions, for each robot, by sequential quadratic programs from
the true one (scipy's SLSQP), and looked at again by plain arithmetic. Their hull is inside the exact one, so the ratio of an
area to its own is no less than to the exact one's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from experiments.beacons.arcs import area_of, corners_of
from experiments.beacons.outcomes import Outcome
from experiments.beacons.scenes import Scene
from experiments.following.frozen import freeze
from filter import Array, Integers, Range

DIRECTIONS = 48
ROOM = 1e-6  # by which ranges are made narrower, so that what nearly keeps these keeps the true ones [m]
STOP = {"maxiter": 60, "ftol": 1e-9}


@dataclass(frozen=True, eq=False)
class Distances:
    """What a team's ranges say of the distances of bodies: (k,) pairs i, j, least and greatest [m].

    Attributes:
        robots: How many of the bodies, the first ones, can be anywhere in the arena.
        arena: (2, 2) its lower and upper corner [m].
        marks: (l, 2) where the others are [m].
        i: One body of each pair.
        j: The other.
        least: At least so far apart [m].
        greatest: At most so far [m].
    """

    robots: int
    arena: Array
    marks: Array
    i: Integers
    j: Integers
    least: Array
    greatest: Array

    def __post_init__(self) -> None:
        freeze(self)

    @classmethod
    def of(cls, scene: Scene) -> Distances:
        """Return what the first instant says; a pair that was measured twice keeps both."""
        records = [record for record in scene.frames[0].measurements if isinstance(record, Range)]
        columns = (np.concatenate([getattr(each, name) for each in records]) for name in ("robot", "target", "range", "bound"))
        i, j, length, bound = columns
        team, least = scene.team, np.maximum(0.0, length - bound)
        return cls(team.robots, team.arena, team.landmarks, i, j, least, length + bound)

    def hold(self, places: Array) -> bool:
        """Return whether all ranges hold for (n, 2) places of the robots [m], and all are in the arena."""
        distance = np.hypot(*self._apart(places).T)
        inside = (places >= self.arena[0]) & (places <= self.arena[1])
        return bool(((distance >= self.least) & (distance <= self.greatest)).all() and inside.all())

    def slack(self, flat: Array) -> Array:
        """Return (2 k,) numbers, none below 0 where all ranges hold with some room; of flattened places."""
        square = (self._apart(flat.reshape(-1, 2)) ** 2).sum(axis=1)
        return np.concatenate([(self.greatest - ROOM) ** 2 - square, square - (self.least + ROOM) ** 2])

    def slope(self, flat: Array) -> Array:
        """Return (2 k, 2 n) derivatives of the slack."""
        apart, rows = 2 * self._apart(flat.reshape(-1, 2)), np.arange(len(self.i))
        of_bodies = np.zeros((len(rows), self.robots + len(self.marks), 2))
        of_bodies[rows, self.j] += apart
        of_bodies[rows, self.i] -= apart
        of_robots = of_bodies[:, : self.robots].reshape(len(rows), -1)
        return np.concatenate([-of_robots, of_robots])

    def _apart(self, places: Array) -> Array:
        bodies = np.concatenate([places, self.marks])
        return np.asarray(bodies[self.j] - bodies[self.i])


def reached(distances: Distances, places: Array, robot: int) -> Array:
    """Return the corners (v, 2) of a hull of places where one robot can be while all ranges hold [m].

    Args:
        distances: What the ranges say.
        places: (n, 2) where all robots are, for one; all ranges hold there [m].
        robot: Which one.
    """
    kept, at = [places[robot]], places.ravel()
    for angle in np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False):
        climbed = _climbed(distances, at, robot, angle)
        if distances.hold(climbed.reshape(-1, 2)):
            at = climbed
            kept.append(climbed.reshape(-1, 2)[robot])
    return corners_of(np.array(kept))


def _climbed(distances: Distances, start: Array, robot: int, angle: float) -> Array:
    """Return a configuration, flattened, in which one robot is as far in a direction as climbing finds, from a start."""
    down = np.zeros(len(start))
    down[2 * robot : 2 * robot + 2] = -np.cos(angle), -np.sin(angle)
    rows = [{"type": "ineq", "fun": distances.slack, "jac": distances.slope}]
    box = list(zip(*np.tile(distances.arena, distances.robots), strict=True))
    found = minimize(
        lambda flat: down @ flat, start, jac=lambda _: down, bounds=box, constraints=rows, method="SLSQP", options=STOP
    )
    return np.asarray(found.x)


@dataclass(frozen=True, eq=False)
class AtMost:
    """How near the exact hulls a filter's regions of a team are.

    Attributes:
        ratios: (n,) area of each region over that of the hull of what was reached: no less than over the exact hull's;
            infinite where nothing was reached.
    """

    ratios: Array

    def __post_init__(self) -> None:
        freeze(self)


def at_most(outcome: Outcome) -> AtMost:
    """Return how near the exact hulls a filter's regions are after the first instant of a team that stands."""
    truth = outcome.scene.frames[0].truth
    distances = Distances.of(outcome.scene)
    places = np.zeros((0, 2)) if truth is None else truth.positions
    areas = np.array([area_of(reached(distances, places, robot)) for robot in range(len(places))])
    return AtMost(np.divide(outcome.areas[0], areas, out=np.full(len(areas), np.inf), where=areas > 0))
