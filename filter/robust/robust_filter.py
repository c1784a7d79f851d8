"""The robust filter: for robots without compass among landmarks, whose declared bounds break now and then."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import zip_longest

import numpy as np

from filter.arrays import Array, Frozen, checked, instance, number, whole_number
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.records.measurements import Bearing, Compass, Measurement, Range
from filter.records.odometry import Odometry
from filter.records.record import AT_THE_CENTRE, called
from filter.robust.belief import RobustBelief
from filter.robust.cameras import Alignment, Offsets
from filter.robust.hypotheses import Hypotheses, reach_of
from filter.robust.merging import Merging
from filter.robust.slices import FARTHEST, Sighting, move
from filter.robust.trust import Suspicion, Trust
from filter.robust.votes import Rules, Votes
from filter.sensing.rows import WIDENING
from filter.team import Team

MOST_CELLS = 10_000  # slices of 0.036 degrees: with a vote or two open, some 10 MB for each robot


@dataclass(frozen=True, eq=False)
class RobustFilter(Frozen):
    """Keeps a belief about a team that contains the truth although some measurements are wrong: a `Filter`.

    The guarantee: every robot is in its region if odometry keeps its bounds and, of the votes on it (see
    `filter.robust.votes`) that no event rejects, at most `rules.tolerated` in any window is wrong. Raises InvalidInput if an
    attribute is not as it should be, or a finite side of the arena or a landmark is beyond 1e6 m.

    Attributes:
        team: The robots, the landmarks and their limits.
        rules: What is assumed of wrong measurements.
        suspicion: When a camera or an identity is put aside.
        alignment: When a camera is suspected to be turned or late.
        cells: How many slices a full circle of headings has, from 8 to 10 000.
    """

    team: Team = field(metadata=checked(instance, "team", Team))
    rules: Rules = field(default_factory=Rules, metadata=checked(instance, "rules", Rules))
    suspicion: Suspicion = field(default_factory=Suspicion, metadata=checked(instance, "suspicion", Suspicion))
    alignment: Alignment = field(default_factory=Alignment, metadata=checked(instance, "alignment", Alignment))
    cells: int = field(default=72, metadata=checked(whole_number, "cells of the circle", 8, MOST_CELLS))

    def __post_init__(self) -> None:
        super().__post_init__()
        _near("landmarks", self.team.landmarks)
        _near("sides of the arena", self.team.arena[np.isfinite(self.team.arena)])

    def start(self, time: float, positions: Sequence[Polygon | None], headings: AngularIntervals | None = None) -> RobustBelief:
        """Return the belief before any measurement; `InvalidInput`, too, if a polygon reaches beyond 1e6 m."""
        begin, robots, bodies = number("time [s]", time), self.team.robots, self.team.robots + len(self.team.landmarks)
        polygons, known = self.team.initial(positions, headings)
        for polygon in polygons:
            _near("initial polygons", polygon.vertices)
        sets = tuple(
            Hypotheses.agreed(reach_of(polygon), centre - bound, centre + bound).cut_anew(self.cells)
            for polygon, centre, bound in zip(polygons, known.centre.tolist(), known.bound.tolist(), strict=True)
        )
        nothing = Votes.none(robots, bodies, begin), Trust.full(robots, bodies, begin), Offsets.none(robots, begin)
        return RobustBelief(begin, sets, *nothing, Guarantee.full(robots), np.full(robots, -np.inf))

    def predict(self, belief: RobustBelief, time: float, odometry: Odometry | None = None) -> RobustBelief:
        """Return the belief at a later time [s], without what is outside the arena; events tell of bounds broken before."""
        self._check(belief)
        time = self.team.check_motion(belief.time, time, odometry)
        distance, turn, aside = _moves(odometry, self.team, time - belief.time)
        offsets = belief.offsets.moved(distance, turn, aside, time - belief.time, self.alignment)
        aside[belief.offsets.turned, 0] = np.pi / 2  # their slices are of the camera's heading
        moves = (partial(move, *way, self.arena) for way in zip(distance, turn, aside, strict=True))
        sets = tuple(known.cut(cut).refitted(self.cells) for known, cut in zip(belief.sets, moves, strict=True))
        after = replace(belief, time=time, sets=sets, offsets=offsets)
        return Merging(after, self.team, self.rules, self.cells, self.arena).left()

    def _check(self, belief: RobustBelief) -> None:
        """Refuse what is no belief about this team."""
        self.team.check_belief(belief, RobustBelief, "sets")
        bodies, known = self.team.robots + len(self.team.landmarks), len(belief.trust.identity)
        if known != bodies:
            raise InvalidInput(f"a belief about a team of {bodies} robots and landmarks", f"one of {known}")

    def update(self, belief: RobustBelief, measurements: Sequence[Measurement] = ()) -> RobustBelief:
        """Return the belief after merging measurements taken at its time, in any order."""
        self._check(belief)
        sightings = sightings_in(self.team.checked(belief.time, measurements), self.team.robots)
        merging = Merging(belief, self.team, self.rules, self.cells, self.arena)
        merging.merge(sightings)
        return merging.ended(sightings, self.suspicion, self.alignment)

    @cached_property
    def arena(self) -> Array:
        """(COUNT,) supports of the arena, or of far more than any robot drives [m]."""
        return reach_of(Polygon.box(*np.clip(self.team.arena, -FARTHEST, FARTHEST)))


def _near(name: str, places: Array) -> None:
    """Refuse places where the robust filter does not reach: what is endless to it would end before them."""
    if (np.abs(places) > FARTHEST).any():
        expected = f"{name} within {FARTHEST:g} m of the origin (subtract one that is near)"
        raise InvalidInput(expected, f"{np.abs(places).max():g} m")


def _moves(odometry: Odometry | None, team: Team, duration: float) -> tuple[Array, Array, Array]:
    """Return least and greatest path and turn, (n, 2) each, and bounds of direction and slip and what is aside, (n, 3)."""
    both = np.array([-1.0, 1.0])
    distance, turn = np.zeros((team.robots, 2)), both * team.turn_rate_limit[:, None] * duration
    aside = np.outer(team.speed_limit * duration, [0.0, 1.0, 0.0])
    if odometry is not None:
        distance[odometry.robot] = odometry.distance[:, None] + odometry.distance_bound[:, None] * both
        turn[odometry.robot] = odometry.turn[:, None] + odometry.turn_bound[:, None] * both
        aside[odometry.robot] = np.stack([odometry.direction_bound, odometry.slip_bound, odometry.aside], axis=1)
    return distance, turn, aside


def sightings_in(measurements: Sequence[Measurement], robots: int) -> list[Sighting]:
    """Return the sightings in records of one time: compasses first, then landmarks, then team mates.

    The n-th bearing of a pair goes with its n-th range. In which order the records come makes no difference, but to that.
    Raises `InvalidInput` for records of other kinds, and of sensors that are mounted elsewhere.
    """
    bearings: dict[tuple[int, int], list[list[float]]] = defaultdict(list)
    ranges: dict[tuple[int, int], list[list[float]]] = defaultdict(list)
    for record in measurements:
        _at_centres(record)
        if isinstance(record, Compass):
            into, target, reading = bearings, record.robot, (record.heading, record.bound)
        elif isinstance(record, Bearing):
            into, target, reading = bearings, record.target, (record.bearing, record.bound + WIDENING)
        elif isinstance(record, Range):
            least, greatest = record.interval()
            into, target, reading = ranges, record.target, (least * (1 - WIDENING), greatest * (1 + WIDENING))
        else:
            raise InvalidInput("what the robust filter can take: compass, bearing, range", called(type(record)))
        for robot, body, *values in zip(*(column.tolist() for column in (record.robot, target, *reading)), strict=True):
            into[robot, body].append(values)
    pairs = sorted(bearings.keys() | ranges.keys(), key=lambda pair: (pair[0] != pair[1], pair[1] < robots, pair))
    return [
        (*pair, np.array(sector))
        for pair in pairs
        for sector in sorted(
            [*(bearing or (0.0, np.pi)), *(reach or (0.0, FARTHEST))]
            for bearing, reach in zip_longest(bearings[pair], ranges[pair])
        )
    ]


def _at_centres(record: Measurement) -> None:
    """Refuse what was measured by sensors that are not at their robots' centres."""
    for name in ("sensor", "target_sensor"):
        numbers = np.atleast_1d(getattr(record, name, AT_THE_CENTRE))
        if (numbers != AT_THE_CENTRE).any():
            raise InvalidInput(
                "readings at robots' centres, as the robust filter knows no mountings", f"{name} {numbers.max()}"
            )
