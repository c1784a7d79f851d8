"""The table of regions: a row for each robot at each step, the same for every format and every filter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from experiments.following.located import Located, Warranted
from filter import Array, GaussianBelief, Integers, Regions

Points = list[list[float]]  # [x, y] each


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a Kalman filter believes of one robot.

    Attributes:
        position: x and y [m].
        heading: [rad].
        covariance: (3, 3) of x, y and heading [m2, m rad, rad2].
    """

    position: list[float]
    heading: float
    covariance: list[list[float]]


@dataclass(frozen=True, eq=False)
class Row:
    """Where one robot is at one step.

    Attributes:
        time: When [s].
        robot: Its name.
        number: Its number, from 0 on.
        outer: Corners, counter-clockwise, of the polygon that contains the robot [m]; None of a filter without regions.
        margin: The polygon that is proved is within the one of these corners, widened by this in x and in y; it is about as
            much as floats round [m].
        inner: Corners of a polygon of which every point is possible [m], or None where nothing is known from inside.
        heading: Centre and bound of the interval that contains the heading [rad], or None.
        area: Of the outer polygon [m2], or None.
        in_force: Whether region and heading are guaranteed.
        ekf: What a Kalman filter believes, or None without one.
    """

    time: float
    robot: str
    number: int
    outer: Points | None
    margin: float | None
    inner: Points | None
    heading: tuple[float, float] | None
    area: float | None
    in_force: bool
    ekf: Estimate | None

    def record(self) -> dict[str, Any]:
        """Return the row as JSON has it; without a Kalman filter there is no `ekf`."""
        heading = None if self.heading is None else {"centre": self.heading[0], "bound": self.heading[1]}
        known = {"time": self.time, "robot": self.robot, "outer": self.outer, "margin_m": self.margin, "inner": self.inner}
        record = known | {"heading": heading, "area_m2": self.area, "in_force": self.in_force}
        return record if self.ekf is None else record | {"ekf": vars(self.ekf)}


def rows_of(
    names: Sequence[str], time: float, belief: Warranted | GaussianBelief, beside: GaussianBelief | None = None
) -> list[Row]:
    """Return the rows of a step, of the robots that are there.

    Args:
        names: (n) of the robots.
        time: When [s].
        belief: What the filter knows. A Kalman filter has no regions, and nothing is in force: it stands for `beside`, too.
        beside: What a Kalman filter believes beside it.
    """
    if isinstance(belief, GaussianBelief):
        nothing = (None,) * 5
        estimates = _estimates(belief)
        told = [Row(time, name, k, *nothing, False, estimates[k]) for k, name in enumerate(names)]
        return [row for row in told if row.number not in belief.away]
    ekf = [None] * len(names) if beside is None else _estimates(beside)
    headings = zip(belief.headings.centre.tolist(), belief.headings.bound.tolist(), strict=True)
    known = zip(_regions(belief), headings, belief.guarantee.in_force.tolist(), strict=True)
    return [
        Row(time, names[k], k, outer, margin, inner, heading, area, in_force, ekf[k])
        for k, ((outer, margin, inner, area), heading, in_force) in enumerate(known)
        if k not in belief.guarantee.away
    ]


def _regions(belief: Located) -> Iterator[tuple[Points, float, Points | None, float]]:
    """Yield each region's outer corners and their margin, its inner corners, and its area."""
    regions = belief.regions
    if not isinstance(regions, Regions):
        for region in regions:
            inner = None if region.inner is None else region.inner.vertices.tolist()
            yield region.outer.vertices.tolist(), region.outer.margin, inner, region.outer.area
        return
    outer, inner = regions.outer, regions.inner  # a whole team's corners at once: five times as fast as one by one
    within = (corners or None for corners in _split(inner.corners, inner.first))
    yield from zip(_split(outer.vertices, outer.first), outer.margin.tolist(), within, outer.areas.tolist(), strict=True)


def _split(corners: Array, first: Integers) -> list[Points]:
    points = corners.tolist()
    return [points[begin:end] for begin, end in pairwise(first.tolist())]


def _estimates(belief: GaussianBelief) -> list[Estimate]:
    robots = len(belief.mean)
    blocks = belief.covariance.reshape(robots, 3, robots, 3)
    means = belief.mean.tolist()
    return [Estimate([x, y], turn, blocks[robot, :, robot].tolist()) for robot, (x, y, turn) in enumerate(means)]
