"""The parts of a tightness experiment that are computed side by side: filters that follow the run, and optima."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from experiments.following.metrics import Metrics
from experiments.following.side_by_side import Case
from experiments.following.steps import steps
from experiments.optimum.history import History, optimum
from filter.arrays import Array
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.geometry.polygon import Polygon
from filter.projection.stop import Stop
from filter.projection.window import Window
from filter.team import Team

# Rows on one robot and rows on one pair.
BUDGETS = {
    "6/6": (6, 6),
    "8/8": (8, 8),
    "12/8": (12, 8),
    "16/12": (16, 12),
    "20/12": (20, 12),
    "24/16": (24, 16),
    "48/32": (48, 32),
}
DEFAULT = "20/12"  # the filter's own


@dataclass(frozen=True)
class Variant:
    """A filter to follow the run with.

    Attributes:
        rows_per_robot: Its budget.
        rows_per_pair: Its budget.
        tangent_spacing: Of ranges [rad].
        window: Whether regions are found in windows instead of in the whole team.
        pairs: Whether pairs are projected, too.
        corners: Whether rows through corners are moved along.
    """

    rows_per_robot: int
    rows_per_pair: int
    tangent_spacing: float
    window: bool = False
    pairs: bool = True
    corners: bool = True

    def filter(self, team: Team) -> SetMembershipFilter:
        """Return the filter.

        Raises:
            InvalidInput: The tangents' spacing is out of its range.
        """
        return SetMembershipFilter(
            team,
            rows_per_robot=self.rows_per_robot,
            rows_per_pair=self.rows_per_pair,
            tangent_spacing=self.tangent_spacing,
            scope=Window() if self.window else Window.everybody(),
            pairs=SetMembershipFilter.pairs if self.pairs else 0,
            corners=self.corners,
            cells=0,  # as in the history: what is compared is what forgetting costs
        )


@dataclass(frozen=True, eq=False)
class Followed:
    """What a filter made of the run.

    Attributes:
        areas: (k, n) of the outer polygons at each step [m2].
        outers: Of each step, of each robot.
        truths: (k, n, 2) where the robots were [m].
        escapes: Positions and headings that were outside.
        rows_max: Greatest number of rows of a belief.
        step_median_ms: How long a step took.
        conflict: What was proved to disagree and stopped the filter, or None.
        history: What the filter was given, if that was asked for.
    """

    areas: Array
    outers: tuple[tuple[Polygon, ...], ...]
    truths: Array
    escapes: int
    rows_max: int
    step_median_ms: float
    conflict: str | None
    history: History | None


def follow(case: Case, variant: Variant, tangents: int | None = None) -> Followed:
    """Follow a run with a filter; write its history down if it is to have so many tangents.

    Raises:
        InvalidInput: The simulator, or the filter, cannot do this.
    """
    scenario, metrics = case.scenario(), Metrics()
    history = None if tangents is None else History(scenario.team, variant.tangent_spacing, tangents)
    outers, truths, seconds, conflict = [], [], [], None
    try:
        for step in steps(variant.filter(scenario.team), scenario):
            metrics.add(step.frame, step.belief, step.seconds)
            outers.append(tuple(region.outer for region in step.belief.regions))
            truths.append(step.frame.truth.positions if step.frame.truth else np.full((case.robots, 2), np.nan))
            seconds.append(step.seconds)
            if history is not None:
                history.add(step)
    except Inconsistent as error:
        conflict, history = str(error), None
    areas = np.array([[outer.area for outer in each] for each in outers])
    escapes, median = metrics.escapes + metrics.heading_escapes, 1e3 * float(np.median(seconds))
    return Followed(areas, tuple(outers), np.array(truths), escapes, metrics.rows_max, median, conflict, history)


@dataclass(frozen=True, eq=False)
class Optimum:
    """The regions that the whole history up to a step leaves.

    Attributes:
        step: Which.
        outers: Polygons that are proved to contain the regions; none when the history is proved to be impossible.
        inners: Polygons that are proved to lie in them; None where no point is proved to.
        variables: Of the linear program.
        rows: Of the linear program.
        searches: Directions that were searched, over all robots.
        seconds: How long that took.
    """

    step: int
    outers: tuple[Polygon, ...]
    inners: tuple[Polygon | None, ...]
    variables: int
    rows: int
    searches: int
    seconds: float

    @property
    def outer_areas(self) -> Array:
        """(n,) [m2]."""
        return np.array([outer.area for outer in self.outers])

    @property
    def inner_areas(self) -> Array:
        """(n,) [m2]; 0 without an inner polygon."""
        return np.array([inner.area if inner else 0.0 for inner in self.inners])

    def outside(self, truths: Array) -> int:
        """Return how many robots at (n, 2) are outside their polygon."""
        return sum(not outer.contains(truth) for outer, truth in zip(self.outers, truths, strict=True))

    def beyond(self, outers: Sequence[Polygon]) -> float:
        """Return how far the farthest point of an inner polygon is outside of its robot's other polygon; negative if inside."""
        pairs = [(inner.vertices, outer) for inner, outer in zip(self.inners, outers, strict=True) if inner]
        return max((float((points @ outer.normals.T - outer.offsets).max()) for points, outer in pairs), default=-np.inf)


def optimum_at(history: History, step: int, stop: Stop) -> Optimum:
    """Find the regions that the whole history up to a step leaves."""
    begin = perf_counter()
    found = optimum(history, step, stop)
    size = history.size(step)
    searches = sum(each.searches for each in found)
    outers, inners = tuple(each.outer for each in found), tuple(each.inner for each in found)
    return Optimum(step, outers, inners, *size, searches, perf_counter() - begin)
