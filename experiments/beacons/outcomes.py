"""What a filter makes of a scene, and how near that is to what the judges say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from experiments.beacons.arcs import Hull
from experiments.beacons.bearings import Sights, exact_hull_of_sights
from experiments.beacons.rings import Rings, exact_hull, tolerant_hull
from experiments.beacons.scenes import Scene
from experiments.following.checks import Checks
from experiments.following.frozen import freeze
from experiments.following.located import outers
from filter import Array, Bearing, Filter, Polygon, Range, follow

UNJUDGED = 0.01  # where a judge does not know the area better than this, it does not judge


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a filter has made of a scene.

    Attributes:
        scene: The scene.
        areas: (k, n) area of each robot's region after each step [m2].
        arcs: (k, n) half-width of each heading's interval [rad].
        seconds: (k,) how long each step took [s].
        last: (n) the regions after the last step.
        checks: What was held against the truth.
        events: What the filter told, and when [s].
    """

    scene: Scene
    areas: Array
    arcs: Array
    seconds: Array
    last: tuple[Polygon, ...]
    checks: Checks
    events: tuple[tuple[float, Any], ...]

    def __post_init__(self) -> None:
        freeze(self)


def followed(filter_: Filter[Any], scene: Scene) -> Outcome:
    """Return what a filter makes of a scene; raises what the filter raises."""
    checks, areas, arcs, seconds, events = Checks(), list[list[float]](), list[Array](), list[float](), list[Any]()
    belief = filter_.start(0.0, scene.initial, scene.headings)
    last = tuple(outers(belief))
    for step in follow(filter_, belief, scene.frames, perf_counter):
        checks.promised(step.belief)
        if step.frame.truth is not None:
            checks.check(step.belief, step.frame.truth)
        last = tuple(outers(step.belief))
        areas.append([outer.area for outer in last])
        arcs.append(step.belief.headings.bound)
        seconds.append(step.seconds)
        events += [(step.frame.time, event) for event in step.belief.events]
    return Outcome(scene, np.array(areas), np.array(arcs), np.array(seconds), last, checks, tuple(events))


@dataclass(frozen=True, eq=False)
class Verdict:
    """What one robot's region is worth after one instant.

    Attributes:
        exact: The hull of all places that agree with what was measured.
        area: The filter's [m2].
        tolerant: Hulls of all places that agree with all ranges but one, by what lies can be; none for bearings.
    """

    exact: Hull
    area: float
    tolerant: dict[str, Hull]

    @property
    def ratio(self) -> float:
        """The filter's area over the exact one, at most."""
        return self.area / self.exact.least

    @property
    def error(self) -> float:
        """The greatest share by which an area may be larger than its least."""
        return max(hull.error for hull in (self.exact, *self.tolerant.values()))

    def price(self, lies: str) -> float:
        """Return how many times as large what is left is if one range may lie."""
        return self.tolerant[lies].least / self.exact.least


def judged(outcome: Outcome) -> Verdict:
    """Return the verdict on a scene with one robot and one instant of either ranges or bearings."""
    scene, box, area = outcome.scene, outcome.scene.team.arena, float(outcome.areas[-1, 0])
    if isinstance(scene.frames[0].measurements[0], Bearing):
        return Verdict(exact_hull_of_sights(sights_of(scene), box), area, {})
    rings = rings_of(scene)
    return Verdict(exact_hull(rings, box), area, {lies: tolerant_hull(rings, box, lies) for lies in ("any", "long")})


def rings_of(scene: Scene) -> Rings:
    """Return the rings of all ranges, with absolute bounds, that one robot measures to anchors at the first instant."""
    ranges = [record for record in scene.frames[0].measurements if isinstance(record, Range)]
    target, length, bound = (np.concatenate([getattr(each, name) for each in ranges]) for name in ("target", "range", "bound"))
    return Rings.measured(scene.team.landmarks[target - 1], length, bound)


def sights_of(scene: Scene) -> Sights:
    """Return the sights of the bearings, with one bound, that one robot measures to landmarks at the first instant."""
    bearings = [record for record in scene.frames[0].measurements if isinstance(record, Bearing)]
    target, angle, bound = (
        np.concatenate([getattr(each, name) for each in bearings]) for name in ("target", "bearing", "bound")
    )
    return Sights(scene.team.landmarks[target - 1], angle, float(bound.max()))


def is_known(verdict: Verdict) -> bool:
    """Return whether the judge knows all areas well enough to judge."""
    return verdict.error <= UNJUDGED


def total(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """Return how much was checked and was outside, in all."""
    counts = [outcome.checks.counts() for outcome in outcomes]
    return {name: sum(each[name] for each in counts) for name in counts[0]}
