"""What a recording shows of one instant, as points and lines; how it looks is in `experiments.show.recording`.

Layers come first in the paths (/world/outer/r3), so that a viewer can switch a layer on and off. `Drawing` has an entity for
each robot and layer; for large teams, of which no viewer could show as many, `Layers` has one for each layer.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from experiments.following.located import Located, there
from filter import Array, Bearing, Frame, Integers, Polygon, Range, Region, Team, Truth

TRAIL = 8.0  # how long a robot's way stays to be seen [s]
UNKNOWN_ARENA = np.array([[-4.0, -4.0], [4.0, 4.0]])  # what is shown at least where the arena has no limits [m]
ARROW = 0.28  # length of the arrow that shows a heading [m]
ALL, PLOTTED = "team", ("mean", "least", "greatest")  # names of what is drawn of a large team
LABEL = 0.1  # how far below a polygon its robot's name stands [m]
# Heights of the layers, so that each covers those below it [m].
HEIGHT = {"fill": 0.004, "trail": 0.008, "rays": 0.012, "outer": 0.020, "inner": 0.024, "truth": 0.030, "estimate": 0.036}


@dataclass(frozen=True, eq=False)
class Strips:
    """Lines through the points of each of several (k, 3) arrays [m]."""

    lines: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Points:
    """Points at (k, 3) positions [m]."""

    positions: Array


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows from (k, 3) origins along (k, 3) vectors [m]."""

    origins: Array
    vectors: Array


@dataclass(frozen=True, eq=False)
class Fans:
    """The insides of convex polygons with (k, 3) vertices each [m]."""

    polygons: tuple[Array, ...]


@dataclass(frozen=True)
class Number:
    """A value of a plot."""

    value: float


Item = Strips | Points | Arrows | Fans | Number


def at_height(points: Array, layer: str) -> Array:
    """Return (k, 2) points as (k, 3) ones at the height of a layer [m]."""
    return np.column_stack([points, np.full(len(points), HEIGHT[layer])])


def closed(polygon: Polygon, layer: str) -> Array:
    """Return the (k + 1, 3) outline of a polygon at the height of a layer, its first point repeated [m]."""
    return at_height(np.concatenate([polygon.vertices, polygon.vertices[:1]]), layer)


def below(polygon: Polygon) -> Array:
    """Return (2,) where a name stands without covering the polygon [m]."""
    return np.array([polygon.centroid[0], polygon.vertices[:, 1].min() - LABEL])


@dataclass
class Drawing:
    """Draws a run, an instant at a time; remembers the robots' trails.

    Attributes:
        team: Whose run it is.
    """

    team: Team
    _trails: dict[int, deque[tuple[float, Array]]] = field(default_factory=dict)

    def items(self, frame: Frame, belief: Located) -> Iterator[tuple[str, Item]]:
        """Yield each entity's path and what it shows at this instant."""
        here = there(belief)
        for robot, region in enumerate(belief.regions):
            yield from self._region(self.team.name(robot), region) if here[robot] else nothing(self.team.name(robot))
        if frame.truth is not None:
            yield from self.truths(frame.truth)
        for robot in np.flatnonzero(here).tolist():
            place = None if frame.truth is None else frame.truth.positions[robot]
            seen = place is not None and bool(np.isfinite(place).all())
            yield self._trail(robot, frame.time, place if place is not None and seen else belief.regions[robot].outer.centroid)
        yield from rays(frame, belief, self.team)

    def truths(self, truth: Truth) -> Iterator[tuple[str, Item]]:
        """Yield each entity's path and where its robot is."""
        for robot in range(self.team.robots):
            yield from self._truth(self.team.name(robot), truth, robot)

    def _region(self, name: str, region: Region) -> Iterator[tuple[str, Item]]:
        yield f"/world/fill/{name}", Fans((at_height(region.outer.vertices, "fill"),))
        yield f"/world/outer/{name}", Strips((closed(region.outer, "outer"),))
        yield f"/world/inner/{name}", Strips((closed(region.inner, "inner"),) if region.inner else ())
        yield f"/world/estimate/{name}", Points(at_height(region.outer.centroid[None], "estimate"))
        yield f"/world/label/{name}", Points(at_height(below(region.outer)[None], "estimate"))
        yield f"/area/{name}", Number(region.outer.area)
        yield f"/performance_ratio/{name}", Number(region.performance_ratio)

    def _truth(self, name: str, truth: Truth, robot: int) -> Iterator[tuple[str, Item]]:
        known = slice(robot, robot + int(np.isfinite(truth.positions[robot]).all()))  # nothing is drawn where nobody knows
        place, heading = at_height(truth.positions[known], "truth"), truth.headings[known]
        yield f"/world/truth/{name}", Points(place)
        along = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(len(heading))])
        yield f"/world/heading/{name}", Arrows(place, ARROW * along)

    def _trail(self, robot: int, time: float, place: Array) -> tuple[str, Item]:
        trail = self._trails.setdefault(robot, deque())
        trail.append((time, place))
        while time - trail[0][0] > TRAIL:
            trail.popleft()
        line = at_height(np.array([point for _, point in trail]), "trail")
        return f"/world/trail/{self.team.name(robot)}", Strips((line,) if len(line) > 1 else ())


@dataclass(frozen=True)
class Layers:
    """Draws a run of a large team, an instant at a time: one entity for each layer, all robots in it; no names, no trails.

    Attributes:
        team: Whose run it is.
    """

    team: Team

    def items(self, frame: Frame, belief: Located) -> Iterator[tuple[str, Item]]:
        """Yield each layer's path and what it shows at this instant, robot by robot."""
        regions = [region for region, here in zip(belief.regions, there(belief), strict=True) if here]
        outers, inners = [region.outer for region in regions], [region.inner for region in regions if region.inner]
        yield f"/world/fill/{ALL}", Fans(tuple(at_height(outer.vertices, "fill") for outer in outers))
        yield f"/world/outer/{ALL}", Strips(tuple(closed(outer, "outer") for outer in outers))
        yield f"/world/inner/{ALL}", Strips(tuple(closed(inner, "inner") for inner in inners))
        yield f"/world/estimate/{ALL}", Points(at_height(np.reshape([outer.centroid for outer in outers], (-1, 2)), "estimate"))
        if frame.truth is not None:
            yield from self.truths(frame.truth)
        yield from rays(frame, belief, self.team)
        yield from _plotted("/area", [outer.area for outer in outers])
        yield from _plotted("/performance_ratio", [region.performance_ratio for region in regions])

    def truths(self, truth: Truth) -> Iterator[tuple[str, Item]]:
        """Yield each layer's path and where the robots are."""
        places, headings = at_height(truth.positions, "truth"), truth.headings
        along = ARROW * np.column_stack([np.cos(headings), np.sin(headings), np.zeros(len(headings))])
        yield f"/world/truth/{ALL}", Points(places)
        yield f"/world/heading/{ALL}", Arrows(places, along)


def nothing(name: str) -> Iterator[tuple[str, Item]]:
    """Yield what is drawn of a robot that is away."""
    yield f"/world/fill/{name}", Fans(())
    yield f"/world/outer/{name}", Strips(())
    yield f"/world/inner/{name}", Strips(())
    for what in ("estimate", "label"):
        yield f"/world/{what}/{name}", Points(np.zeros((0, 3)))
    for plot in ("area", "performance_ratio"):
        yield f"/{plot}/{name}", Number(np.nan)  # or a line would be drawn to when it is back


def _plotted(plot: str, values: Sequence[float]) -> Iterator[tuple[str, Item]]:
    if not values:  # everybody is away
        return
    for name, value in zip(PLOTTED, (float(np.mean(values)), min(values), max(values)), strict=True):
        yield f"{plot}/{name}", Number(value)


def rays(frame: Frame, belief: Located, team: Team) -> Iterator[tuple[str, Item]]:
    """Yield, for bearings and for ranges, lines between those that measured and what they measured."""
    places = np.concatenate([[region.outer.centroid for region in belief.regions], team.landmarks])
    for kind in (Bearing, Range):
        records = [record for record in frame.measurements if isinstance(record, kind)]
        pairs = [pair for record in records for pair in zip(record.robot, record.target, strict=True)]
        lines = tuple(at_height(places[list(pair)], "rays") for pair in pairs)
        yield f"/world/rays/{kind.__name__.lower()}", Strips(lines)


def triangles_of(counts: Sequence[int]) -> Integers:
    """Return (t, 3) the triangles, as numbers of vertices laid end to end, of fans with so many vertices."""
    corners = [(at, k) for at, count in zip(np.cumsum([0, *counts]), counts, strict=False) for k in range(1, count - 1)]
    return np.array([[at, at + k, at + k + 1] for at, k in corners], dtype=np.int64).reshape(-1, 3)


def extent_of(team: Team) -> tuple[Array, Array]:
    """Return lower and upper corner of what the view from above shows."""
    if np.isfinite(team.arena).all():
        return team.arena[0], team.arena[1]
    points = np.concatenate([team.landmarks, UNKNOWN_ARENA])
    return points.min(axis=0), points.max(axis=0)
