"""Which of all that an update rests on exclude one another: proved by themselves, and none of them can be left out.

A certificate names the rows that it uses. They rest on more: on headings, and on the directions in which targets can be, which
come from everything else that is known and measured. So all of it is taken apart, and the update is done again with few parts,
of robots that can be anywhere and head anywhere. What excludes one another then, does so by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.sources import KINDS, Kind, Source, Sources
from filter.records.measurements import Measurement, Position
from filter.records.odometry import Odometry
from filter.records.record import field_names
from filter.sensing.readings import KIND_OF, targets_of
from filter.sets.belief import Belief
from filter.team import Team

FAR = 1e3  # where no arena ends it, "anywhere" reaches so many times the extent of all that is known beyond that

Reading = tuple[int, int]  # of which record, in which place of it
Motion = tuple[float, Odometry | None]  # until when [s], and what is measured of it


class Part(NamedTuple):
    """A part of what an update rests on: what it is, and if it is a measurement, which one."""

    source: Source
    reading: Reading | None = None


Parts = tuple[Part, ...]
Excludes = Callable[[Parts], bool]  # whether parts are proved to exclude one another
# Whether a belief, after a motion in an arena (2, n, 2) that each robot has of its own, is proved to exclude records.
Attempt = Callable[[Belief, Motion | None, Array, tuple[Measurement, ...]], bool]


@dataclass(frozen=True, eq=False)
class Premises:
    """All that an update rests on, or a prediction, in parts that can be left out.

    Attributes:
        before: What was known before the motion, or if there was none before the measurements.
        motion: The motion since, or None.
        measurements: What was measured then.
        team: The robots and the arena.
        attempt: Does the update again.
    """

    before: Belief
    motion: Motion | None
    measurements: tuple[Measurement, ...]
    team: Team
    attempt: Attempt
    _known: dict[frozenset[Part], bool] = field(default_factory=dict)

    @cached_property
    def parts(self) -> Parts:
        """What was known before, motions and measurements. Which are named where there is a choice: the first ones."""
        then, robots = self.before.time, range(self.team.robots)
        sources, initial = self.before.sources, KINDS.index("initial set")
        is_start = self.before.found is None and bool(((sources.time == then) & (sources.kind == initial)).all())
        known = [Source("initial set" if is_start else "region", then, robot) for robot in robots]
        known += [Source("heading", then, robot) for robot in np.flatnonzero(~self.before.headings.full).tolist()]
        i, j, _ = self.before.constraints.grouped()
        known += [Source("pair", then, one, other) for one, other in zip(i.tolist(), j.tolist(), strict=True) if one != WORLD]
        readings = (Part(source, reading) for reading, source in single(self.measurements).items())
        return (*map(Part, known), *map(Part, self._motions()), *readings)

    def _motions(self) -> list[Source]:
        if self.motion is None:
            return []
        time, odometry = self.motion
        driven = set[int]() if odometry is None else set(odometry.robot.tolist())
        limits: tuple[Kind, ...] = ("speed limit", "turn limit")
        others = (robot for robot in range(self.team.robots) if robot not in driven)
        return [Source("odometry", time, robot) for robot in sorted(driven)] + [
            Source(limit, time, robot) for robot in others for limit in limits
        ]

    def arenas(self, robots: Iterable[int]) -> Parts:
        """Return that some robots are in the arena, if there is one."""
        time = self.before.time if self.motion is None else self.motion[0]
        return tuple(Part(Source("arena", time, robot)) for robot in robots if np.isfinite(self.team.arena).any())

    def robots_of(self, sources: Iterable[Source]) -> set[int]:
        """Return the robots that measured, were seen, or are spoken of."""
        bodies = {body for source in sources for body in (source.robot, source.target)}
        return {body for body in bodies if body is not None and body < self.team.robots}

    def near(self, parts: Parts, named: Collection[Source]) -> Parts:
        """Return the parts that a certificate's sources suggest: these, and what is known of the robots that they are about."""
        robots, between = self.robots_of(named), {frozenset((each.robot, each.target)) for each in named}

        def is_near(source: Source) -> bool:
            if source.kind == "range":
                return source in named
            if source.kind == "bearing":
                return frozenset((source.robot, source.target)) in between
            return self.robots_of([source]) <= robots

        return tuple(part for part in parts if is_near(part.source))

    def exclude(self, parts: Parts) -> bool:
        """Return whether some parts are proved to exclude one another, all others left out."""
        held = frozenset(parts)
        if held not in self._known:
            self._known[held] = self.attempt(*self._only(held))
        return self._known[held]

    def _only(self, held: frozenset[Part]) -> tuple[Belief, Motion | None, Array, tuple[Measurement, ...]]:
        """Return what to attempt with the parts held."""
        of = {kind: np.zeros(self.team.robots, dtype=bool) for kind in KINDS}
        for part in held:
            of[part.source.kind][part.source.robot] = True
        rests = self.motion is None  # a robot of whose motion nothing is held has gone, and turned, anywhere
        moved, turned = (of["odometry"] | of[limit] | rests for limit in ("speed limit", "turn limit"))
        placed = (of["initial set"] | of["region"]) & moved
        lower, upper, limits = self._boxes(placed, of["arena"])
        rows = self.before.constraints.select(self._rows(placed, moved, [part.source for part in held]))
        headings, polytope = self.before.headings, Polytope(rows, lower, upper, self.before.polytope.origin)
        arcs = AngularIntervals(headings.centre, np.where(of["heading"] & turned, headings.bound, np.pi))
        dropped = {part.reading for part in self.parts if part.reading is not None and part not in held}
        at_home = of["arena"] | ~np.isfinite(self.team.arena).any()
        both = np.flatnonzero(~(placed & of["heading"] & turned & at_home))  # are not known together
        before = replace(self.before, polytope=polytope, headings=arcs, slices=self.before.slices.without(both))
        return before, self.motion, limits, without(self.measurements, dropped)

    def _boxes(self, placed: Mask, inside: Mask) -> tuple[Array, Array, Array]:
        """Return corners (n, 2) and (n, 2) of boxes before the motion, and each robot's own arena (2, n, 2) after it.

        (n,) are which robots are placed, and which are inside the arena.
        """
        arena, anywhere = self.team.arena[:, None], self._anywhere[:, None]
        limits = np.where(inside[:, None] & np.isfinite(arena), arena, anywhere)
        box = np.stack([self.before.polytope.lower, self.before.polytope.upper])
        own = placed[:, None] & (inside[:, None] | (box != arena))  # a side that a set has in common with the arena is its
        lower, upper = np.where(own, box, limits)
        return lower, upper, limits

    def _rows(self, placed: Mask, moved: Mask, held: Iterable[Source]) -> Mask:
        """Return which rows are left, where (n,) robots are placed, and (n,) have moved by as much as is known."""
        rows, robots = self.before.constraints, self.team.robots
        pairs = [source.robot * robots + (source.target or 0) for source in held if source.kind == "pair"]
        mutual = np.isin(rows.i * robots + rows.j, np.array(pairs, dtype=np.int64)) & moved[rows.i] & moved[rows.j]
        return np.asarray(np.where(rows.i == WORLD, placed[rows.j], mutual))

    @cached_property
    def _anywhere(self) -> Array:
        return anywhere(self.before, self.team)


def anywhere(belief: Belief, team: Team) -> Array:
    """Return (2, 2) corners of a box far around all that is known [m]."""
    lower, upper, arena = belief.polytope.lower, belief.polytope.upper, team.arena
    places = np.concatenate([lower, upper, team.landmarks, np.where(np.isfinite(arena), arena, lower[0])])
    least, greatest = places.min(axis=0), places.max(axis=0)
    far = FAR * max(1.0, float((greatest - least).max()))
    return np.stack([least - far, greatest + far])


def conflict_of(error: Inconsistent, cases: Sequence[Premises]) -> tuple[Source, ...]:
    """Return what is in conflict where an update has raised an error, by itself and the newest last.

    Of several cases, each of which tells all that the update rests on, the first counts that can be proved. That robots are in
    the arena is taken for granted first, and is named only if the others do not exclude one another without.
    """
    for case in cases:
        parts = case.parts
        for some in (case.near(parts, error.sources), parts):
            around = case.arenas(range(case.team.robots))
            if case.exclude(around + some):
                found = minimal(case.exclude, around, some)
                touched = case.robots_of(part.source for part in found)
                return _in_time(minimal(case.exclude, found, case.arenas(sorted(touched))) + found)
    return _in_time(parts)


def _in_time(parts: Parts) -> tuple[Source, ...]:
    return tuple(sorted((part.source for part in parts), key=lambda source: source.time))


def minimal(exclude: Excludes, always: Parts, parts: Parts) -> Parts:
    """Return parts that exclude one another with what is there always, and no more do so without any one of them.

    Algorithm:
        QuickXplain (Junker, Preferred explanations and relaxations for over-constrained problems, 2004). That more parts
        exclude one another if fewer do is true of the mathematics, and nearly of solvers; so what it says is checked once more.
    """
    found = _explained(exclude, always, True, parts)
    found = found if exclude(always + found) else parts
    for part in found:
        fewer = tuple(other for other in found if other is not part)
        found = fewer if exclude(always + fewer) else found
    return found


def _explained(exclude: Excludes, always: Parts, more: bool, parts: Parts) -> Parts:
    if not parts or (more and exclude(always)):
        return ()
    if len(parts) == 1:
        return parts
    first, last = parts[: len(parts) // 2], parts[len(parts) // 2 :]
    of_last = _explained(exclude, always + first, True, last)
    return _explained(exclude, always + of_last, bool(of_last), first) + of_last


def single(measurements: Sequence[Measurement]) -> dict[Reading, Source]:
    """Return every single measurement, in order, as a source."""
    found = dict[Reading, Source]()
    for k, record in enumerate(measurements):
        table, _ = Sources().extended(KIND_OF[type(record)], record.time, record.robot, targets_of(record), record.sensor)
        found |= {(k, place): table[place] for place in np.unique(_first_places(record)).tolist()}
    return found


def _first_places(record: Measurement) -> Integers:
    """Return (k,) where in a record the measurement begins that each place is of."""
    return record.first if isinstance(record, Position) else np.arange(len(record.robot))


def without(measurements: Sequence[Measurement], dropped: Collection[Reading]) -> tuple[Measurement, ...]:
    """Return the records with some single measurements left out, and records of which nothing is left."""
    left = []
    for k, record in enumerate(measurements):
        keep = np.array([(k, place) not in dropped for place in _first_places(record).tolist()], dtype=bool)
        if keep.any():
            left.append(replace(record, **{name: getattr(record, name)[keep] for name in field_names(record)}))
    return tuple(left)
