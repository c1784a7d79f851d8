"""A formation localized in the frame of its anchors: regions of robots, and of relative positions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from experiments.paper.formations import Formation, Searcher
from experiments.paper.reference import Unbounded
from filter.arrays import Array, Integers, whole
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import InvalidInput
from filter.projection.proved import Projection, position
from filter.projection.stop import Budget, Stop
from filter.sets.belief import Belief
from filter.team import Team

PAIRS = 3  # relative positions that are looked at when the caller chooses none


@dataclass(frozen=True, eq=False)
class Localized:
    """A formation in one frame.

    Attributes:
        formation: With the truth in the frame's coordinates.
        anchors: (n, 2) anchored coordinates [m], NaN where free.
        belief: What the filter makes of the bearings.
    """

    formation: Formation
    anchors: Array
    belief: Belief

    @property
    def variables(self) -> int:
        """How many coordinates are free."""
        return int(np.isnan(self.anchors).sum())

    @property
    def references(self) -> list[int]:
        """Robots of which both coordinates are anchored."""
        return np.flatnonzero(~np.isnan(self.anchors).any(axis=1)).tolist()

    @property
    def free(self) -> Integers:
        """(f,) robots of which no coordinate is anchored."""
        return np.flatnonzero(np.isnan(self.anchors).all(axis=1))

    @property
    def escaped(self) -> list[int]:
        """Robots outside their outer polygons: a broken guarantee."""
        truths = zip(self.belief.regions, self.formation.positions, strict=True)
        return [robot for robot, (region, place) in enumerate(truths) if not region.outer.contains(place)]


def localize(formation: Formation, anchors: Array, stop: Stop, solver: str = "piqp", budget: Budget | None = None) -> Localized:
    """Return the formation's regions in the frame of the anchors, found by search.

    Raises:
        InvalidInput: There is no such solver.
        Unbounded: The anchors do not bound the formation.
        Inconsistent: Some bound is broken.
    """
    team = Team(len(formation), speed_limit=0.0, turn_rate_limit=0.0)
    static_filter = SetMembershipFilter.light(team, exact=False, solvers=(solver,), stop=stop, budget=budget)  # nothing moves
    case = formation.case(anchors)
    prior = static_filter.start(0.0, case.initial, case.headings)
    return Localized(formation, anchors, static_filter.update(prior, [formation.bearings]))


@dataclass(frozen=True, eq=False)
class Relative:
    """Where one robot is as seen from another.

    Attributes:
        robot: i of x_i - x_j.
        other: j.
        truth: (2,) x_i - x_j [m].
        region: Its projection.
    """

    robot: int
    other: int
    truth: Array
    region: Projection

    @property
    def escaped(self) -> bool:
        """Whether the truth is outside the outer polygon: a broken guarantee."""
        return not self.region.outer.contains(self.truth)


def relative_regions(
    localized: Localized,
    pairs: Sequence[tuple[int, int]],
    stop: Stop,
    solver: str = "piqp",
    budget: Budget | None = None,
) -> list[Relative]:
    """Return the regions of x_i - x_j for pairs (i, j) of robots; a budget is of each of them.

    Raises:
        InvalidInput: A pair names an unknown robot, or one twice.
    """
    formation = localized.formation
    searcher = Searcher(formation.polytope(localized.anchors), solver)
    regions = []
    for i, j in pairs:
        if not len(set(whole("robots of a pair", [i, j]).tolist()) & set(range(len(formation)))) == 2:
            raise InvalidInput(f"pairs of two robots among 0 to {len(formation) - 1}", f"{i} and {j}")
        truth = formation.positions[i] - formation.positions[j]
        D = position(i, len(formation)) - position(j, len(formation))  # eq. 3
        regions.append(Relative(i, j, truth, searcher.project(D, stop, budget)))
    return regions


def uncertain_pairs(localized: Localized) -> list[tuple[int, int]]:
    """Return the robots with the largest regions, each with the nearest robot that it sees."""
    formation, regions = localized.formation, localized.belief.regions
    largest = sorted(localized.free.tolist(), key=lambda robot: -regions[robot].outer.area)[:PAIRS]
    return [(robot, _nearest(formation, robot)) for robot in largest if formation.neighbours(robot)]


def _nearest(formation: Formation, robot: int) -> int:
    away = formation.positions - formation.positions[robot]
    return min(formation.neighbours(robot), key=lambda other: float(np.hypot(*away[other])))


def farthest_reference(formation: Formation, reference: int = 0) -> int | None:
    """Return the robot farthest from a reference whose own frame is bounded, or None when no other's is."""
    for robot in _farthest_first(formation, reference):
        with suppress(Unbounded, InvalidInput):
            formation.polytope(formation.anchors([robot]))
            return robot
    return None


def _farthest_first(formation: Formation, reference: int) -> Iterator[int]:
    away = formation.positions - formation.positions[reference]
    for robot in np.argsort(-np.hypot(away[:, 0], away[:, 1]), kind="stable").tolist():
        if robot != reference:
            yield robot
