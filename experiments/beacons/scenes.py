"""What is drawn: robots that stand among anchors, alone or as a team, and teams that drive, all of which measure ranges alone.

Plain kinematics: every error is drawn uniformly within its bound, and so is what wheels do beside rolling.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, islice

import numpy as np

from experiments.following.frozen import freeze
from filter import AngularIntervals, Array, Bearing, Frame, Odometry, Polygon, Range, Team, Truth, wrap

ARENA = np.array([[-3.0, -3.0], [13.0, 12.0]])  # of those that stand [m]; they can be anywhere in it at the start
ANCHORS = np.array([[0.0, 0.0], [10.0, 1.0], [4.0, 9.0]])  # of a team that stands [m]
PLACES = np.array([[3.0, 3.0], [6.0, 4.0], [5.0, 7.0], [2.0, 6.0]])  # and its robots
ABOUT = 1.0  # all of these are moved by at most that along each axis [m]
MARGIN = 1.0  # from the arena's sides to anchors [m]
BEARING_BOUND = np.radians(2.0)
DT = 0.2  # between two steps of those that drive [s]
PATH, LIMIT = 0.05, 6.0  # driven in a step, and where they turn back [m]
STARTED = 0.5  # half the side of the square that a driving robot is in at the start [m]
WHEELS = {"distance_bound": 0.002, "turn_bound": 0.005, "direction_bound": np.radians(1.0), "slip_bound": 0.001}


@dataclass(frozen=True, eq=False)
class Scene:
    """A team, what is known of it at the start, and what it measures.

    Attributes:
        kind: What it is a draw of.
        team: The robots and the anchors.
        initial: (n) where they are at time 0, None for anywhere in the arena.
        headings: Arcs around their headings then, or None where nothing is known.
        frames: What happens, with the truth.
    """

    kind: str
    team: Team
    initial: tuple[Polygon | None, ...]
    headings: AngularIntervals | None
    frames: tuple[Frame, ...]


def alone(generator: np.random.Generator, anchors: int, bound: float) -> Scene:
    """Return one robot that stands anywhere in the arena and measures its range to each anchor once, off by a bound [m]."""
    marks, places = _anywhere(generator, anchors, MARGIN), _anywhere(generator, 1)
    return _standing("alone", marks, places, np.zeros(1), [_ranges(generator, places, marks, np.inf, bound)])


def team_that_stands(generator: np.random.Generator, bound: float) -> Scene:
    """Return four robots among three anchors; all measure all, and the same readings come at two instants."""
    marks, places = (known + generator.uniform(-ABOUT, ABOUT, known.shape) for known in (ANCHORS, PLACES))
    ranges = _ranges(generator, places, marks, np.inf, bound)
    return _standing("standing", marks, places, np.zeros(len(places)), [ranges, ranges])


def bearings_alone(generator: np.random.Generator) -> Scene:
    """Return one robot anywhere in the arena that sees four landmarks, knows nothing of its heading, and measures bearings."""
    marks, places = _anywhere(generator, 4, MARGIN), _anywhere(generator, 1)
    heading, errors = generator.uniform(-np.pi, np.pi, 1), generator.uniform(-BEARING_BOUND, BEARING_BOUND, 4)
    apart = marks - places
    bearings = wrap(np.arctan2(apart[:, 1], apart[:, 0]) - heading + errors)
    return _standing("bearings", marks, places, heading, [Bearing(0.0, 0, np.arange(1, 5), bearings, BEARING_BOUND)])


def _standing(kind: str, marks: Array, places: Array, headings: Array, records: Sequence[Bearing | Range]) -> Scene:
    """Return robots that stand, can be anywhere in the arena, and get a record at each second."""
    team, truth = Team(len(places), marks, 0.0, 0.0, ARENA), Truth(places, headings)
    frames = [Frame(float(k), None, (replace(record, time=float(k)),), truth) for k, record in enumerate(records, 1)]
    return Scene(kind, team, (None,) * len(places), None, tuple(frames))


def _anywhere(generator: np.random.Generator, count: int, margin: float = 0.0) -> Array:
    """Return (count, 2) places in the arena, so far from its sides [m]."""
    return ARENA[0] + margin + generator.random((count, 2)) * (ARENA[1] - ARENA[0] - 2 * margin)


@dataclass(frozen=True, eq=False)
class Drive:
    """A team that drives among anchors and measures ranges; at the start each robot is in a square of 1 m.

    Attributes:
        kind: What it is called.
        robots: How many.
        marks: (l, 2) the anchors [m].
        sight: How far ranges are measured [m].
        known: Within what headings are known at the start [rad], or None.
        seed: Those with the same one drive and measure the same.
    """

    kind: str
    robots: int
    marks: Array
    sight: float
    known: float | None
    seed: int

    def __post_init__(self) -> None:
        freeze(self)

    def drawn(self, seeds: Sequence[int], steps: int, bound: float) -> Scene:
        """Return a scene of so many steps, ranges off by a bound [m] at most; all randomness comes from seeds and its own."""
        generator = np.random.default_rng([*seeds, self.seed])
        places = generator.uniform(-LIMIT / 2, LIMIT / 2, (self.robots, 2))
        headings, off = generator.uniform(-np.pi, np.pi, self.robots), generator.uniform(-1, 1, self.robots)
        middles = places + generator.uniform(-STARTED, STARTED, (self.robots, 2))
        initial = tuple(Polygon.box(middle - STARTED, middle + STARTED) for middle in middles)
        half = None if self.known is None else np.full(self.robots, self.known)
        arcs = None if half is None else AngularIntervals(headings + half * off, half)
        outermost = np.full(2, LIMIT + 2)
        team = Team(self.robots, self.marks, 0.5, 1.5, np.array([-outermost, outermost]))
        frames = islice(self._frames(generator, places, headings, bound), steps)
        return Scene(self.kind, team, initial, arcs, tuple(frames))

    def _frames(self, generator: np.random.Generator, places: Array, headings: Array, bound: float) -> Iterator[Frame]:
        curve = generator.uniform(-0.08, 0.08, self.robots)
        for k in count():
            curve = np.clip(curve + generator.uniform(-0.02, 0.02, self.robots), -0.1, 0.1)
            home = wrap(np.arctan2(-places[:, 1], -places[:, 0]) - headings)
            turn = np.where(np.hypot(*places.T) > 0.8 * LIMIT, np.clip(home, -0.2, 0.2), curve)
            told = Odometry(k * DT, (k + 1) * DT, np.arange(self.robots), PATH, turn=turn, **WHEELS)
            places, headings = moved(generator, places, headings, told)
            ranges = replace(_ranges(generator, places, self.marks, self.sight, bound), time=told.time)
            yield Frame(told.time, told, (ranges,), Truth(places, wrap(headings)))


MARKS = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, -1.0]])
DRIVES = (
    Drive("moving", 3, MARKS, 8.0, None, 1),
    Drive("moving_known", 3, MARKS, 8.0, np.radians(10.0), 1),
    Drive("moving_six", 6, MARKS[[0, 2]], 5.0, None, 2),
)


def moved(generator: np.random.Generator, places: Array, headings: Array, told: Odometry) -> tuple[Array, Array]:
    """Return where robots are after they have driven arcs of circles within the bounds of what is told of it."""
    off, turned, aside, slip = generator.uniform(-1, 1, (4, len(places)))
    path, turn = told.distance + off * told.distance_bound, told.turn + turned * told.turn_bound
    way, slid = headings + turn / 2 + aside * told.direction_bound, generator.uniform(-np.pi, np.pi, len(places))
    chord = path * np.sinc(turn / 2 / np.pi)
    gone = chord[:, None] * _unit(way) + (np.abs(slip) * told.slip_bound)[:, None] * _unit(slid)
    return places + gone, headings + turn


def _unit(angles: Array) -> Array:
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _ranges(generator: np.random.Generator, places: Array, marks: Array, sight: float, bound: float) -> Range:
    """Return at time 0 the ranges from each robot to all bodies in sight, no less than 0 as they are measured."""
    bodies = np.concatenate([places, marks])
    distance = np.hypot(*(bodies - places[:, None]).transpose(2, 0, 1))
    robot, target = np.nonzero((distance <= sight) & ~np.eye(len(places), len(bodies), dtype=bool))
    true = distance[robot, target]
    return Range(0.0, robot, target, np.maximum(0.0, true + generator.uniform(-bound, bound, len(true))), bound, 0.0)
