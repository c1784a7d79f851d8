"""Small worlds for the tests: robots that move and measure within their bounds, drawn from a generator, without MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from scipy import sparse

from filter import Bearing, Compass, Measurement, Odometry, Range
from filter.arrays import Array, Integers
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.program import LinearProgram
from filter.linear.sources import Sources
from filter.projection.claims import Weights
from filter.sets.belief import Belief
from filter.sets.proof import Proof
from filter.team import Team

NO_INDEX = np.zeros(0, dtype=np.int64)
NO_ROWS = Constraints(NO_INDEX, NO_INDEX, np.zeros((0, 2)), np.zeros(0), NO_INDEX)


@dataclass
class World:
    """A team whose every error is drawn by `error`: `uniform` over the bound, or `extreme`, at plus or minus the bound."""

    rng: np.random.Generator
    robots: int = 4
    landmarks: int = 1
    size: float = 6.0
    errors: str = "uniform"
    compass: float = np.radians(3)
    bearing: float = np.radians(3)
    range: float = 0.05
    sight: float = 4.0
    origin: Array = field(default_factory=lambda: np.zeros(2))
    time: float = 0.0

    def __post_init__(self) -> None:
        self.positions = self.origin + self.rng.uniform(0, self.size, (self.robots, 2))
        self.headings = self.rng.uniform(-np.pi, np.pi, self.robots)
        marks = self.origin + self.rng.uniform(0, self.size, (self.landmarks, 2))
        self.team = Team(self.robots, marks, speed_limit=0.5, turn_rate_limit=2.0)

    def error(self, size: int | tuple[int, ...]) -> Array:
        if self.errors == "extreme":
            return self.rng.choice([-1.0, 1.0], size)
        return self.rng.uniform(-1, 1, size)

    def initial_sets(self, reach: float = 0.5) -> list[Polygon]:
        centres = self.positions + reach * self.error((self.robots, 2))
        return [Polygon.box(centre - reach - 1e-9, centre + reach + 1e-9) for centre in centres]

    def initial_headings(self, bound: float = 0.2) -> AngularIntervals:
        return AngularIntervals(self.headings + bound * self.error(self.robots), np.full(self.robots, bound + 1e-9))

    def move(self, duration: float = 0.1, backwards: bool = False) -> Odometry:
        """Drive arcs with slip; the record's bounds hold, some of them just so."""
        speed = self.rng.uniform(-0.5 if backwards else 0, 0.5, self.robots)
        return self.drive(speed * duration, self.rng.uniform(-2, 2, self.robots) * duration, duration)

    def tour(self, duration: float = 0.4) -> Odometry:
        """Drive on and on, more or less straight, back to the middle from the rim."""
        away = self.origin + self.size / 2 - self.positions
        home = wrap(np.arctan2(away[:, 1], away[:, 0]) - self.headings)
        wanted = np.where(np.hypot(*away.T) > self.size / 2, home, self.rng.uniform(-0.5, 0.5, self.robots))
        return self.drive(np.full(self.robots, 0.4 * duration), np.clip(wanted, -duration, duration), duration)

    def drive(self, distance: Array, turn: Array, duration: float) -> Odometry:
        """Drive arcs of given lengths (n,) [m] and turns (n,) [rad], with slip; the record's bounds hold, some just so."""
        n, start = self.robots, self.time
        distance_bound, turn_bound, slip = 0.02 * np.abs(distance) + 1e-4, np.full(n, 0.01), np.full(n, 0.002)
        direction_bound = np.full(n, 0.02)
        way = self.headings + turn / 2 + direction_bound * self.error(n)
        chord = distance * np.sinc(turn / 2 / np.pi)
        slipped = self.rng.uniform(-np.pi, np.pi, n)
        self.positions = self.positions + (
            chord[:, None] * np.stack([np.cos(way), np.sin(way)], 1)
            + slip[:, None] * np.stack([np.cos(slipped), np.sin(slipped)], 1)
        )
        self.headings, self.time = wrap(self.headings + turn), start + duration
        return Odometry(
            start=start,
            time=self.time,
            robot=np.arange(n),
            distance=distance + distance_bound * self.error(n),
            distance_bound=distance_bound + 1e-12,
            turn=turn + turn_bound * self.error(n),
            turn_bound=turn_bound + 1e-12,
            direction_bound=direction_bound + 1e-12,
            slip_bound=slip + 1e-12,
        )

    def measure(self, compasses: bool = True) -> list[Measurement]:
        bodies = np.concatenate([self.positions, self.team.landmarks])
        robot, target = np.divmod(np.arange(self.robots * len(bodies)), len(bodies))
        difference = bodies[target] - self.positions[robot]
        distance = np.hypot(*difference.T)
        seen = (robot != target) & (distance < self.sight)
        robot, target, difference, distance = robot[seen], target[seen], difference[seen], distance[seen]
        way = np.arctan2(difference[:, 1], difference[:, 0]) - self.headings[robot]
        records: list[Measurement] = []
        if compasses:
            shown = self.headings + self.compass * self.error(self.robots)
            records.append(Compass(self.time, np.arange(self.robots), shown, self.compass + 1e-12))
        if len(robot):
            bearing = way + self.bearing * self.error(len(robot))
            records.append(Bearing(self.time, robot, target, bearing, self.bearing + 1e-12))
            measured = distance * (1 + self.range * self.error(len(robot)))
            records.append(Range(self.time, robot, target, measured, 1e-9, self.range))
        return records

    def steps(self, count: int, **options: bool) -> Iterator[tuple[Odometry, list[Measurement]]]:
        for _ in range(count):
            yield self.move(**options), self.measure()


def exact_slack(normal: Array, offset: float, point: Array) -> Fraction:
    """Return offset - normal . point without any rounding, for floats taken as they are."""
    products = (Fraction(float(a)) * Fraction(float(x)) for a, x in zip(normal, point, strict=True))
    return Fraction(float(offset)) - sum(products, Fraction(0))


def claims_of(
    polytope: Polytope, whose: tuple[Integers, Integers], lines: tuple[Array, Array], used: tuple[Integers, Array]
) -> Proof:
    """Return claims on robots or pairs i, j (k): normals (k, 2), offsets (k,), rows and multipliers (k, p), 0 for none."""
    claim, place = np.nonzero(used[1])
    first = np.searchsorted(claim, np.arange(len(used[1]) + 1))
    weights = Weights(used[0][claim, place], used[1][claim, place], first)
    return Proof("regions", polytope, Sources(), *whose, *lines, weights)


def exact_claim(proof: Proof, claim: int) -> Fraction:
    """Return by how much the least offset that a claim's multipliers prove, without any rounding, exceeds the claimed one."""
    rows, box = proof.polytope.constraints, (proof.polytope.lower, proof.polytope.upper)
    normal, total = [Fraction(float(x)) for x in proof.normal[claim]], -Fraction(float(proof.offset[claim]))
    left = {int(proof.j[claim]): list(normal)}
    if proof.i[claim] != WORLD:
        left[int(proof.i[claim])] = [-x for x in normal]
    used, prices = proof.rests_on(claim)
    for row, price in zip(used.tolist(), map(Fraction, prices.tolist()), strict=True):
        total += price * Fraction(float(rows.offset[row]))
        for robot, sign in ((int(rows.j[row]), 1), (int(rows.i[row]), -1)):
            if robot != WORLD:
                rest = left.setdefault(robot, [Fraction(0), Fraction(0)])
                left[robot] = [x - sign * price * Fraction(n) for x, n in zip(rest, rows.normal[row].tolist(), strict=True)]
    for robot, rest in left.items():
        total += sum(
            max(x * Fraction(float(box[0][robot, m])), x * Fraction(float(box[1][robot, m]))) for m, x in enumerate(rest)
        )
    return total


def offset_through(normal: Array, point: Array) -> float:
    """Return the least float offset with which a half-plane contains the point without any rounding."""
    offset = float(-exact_slack(normal, 0.0, point))
    return offset if exact_slack(normal, offset, point) >= 0 else float(np.nextafter(offset, np.inf))


def exact_row_slack(row: int, belief: Belief, positions: Array) -> Fraction:
    """Return the slack of one row of the belief at the positions (n, 2), without any rounding."""
    rows = belief.constraints
    normal, (i, j) = rows.normal[row], (rows.i[row], rows.j[row])
    if i == WORLD:
        return exact_slack(normal, rows.offset[row], positions[j])
    return exact_slack([*normal, *-normal], rows.offset[row], [*positions[j], *positions[i]])


def escapes(belief: Belief, positions: Array, headings: Array | None = None) -> list[str]:
    """Return, in words, everything in the belief that the true positions (n, 2) and headings (n) break."""
    rows = belief.constraints
    found = []
    for row in range(len(rows)):
        if exact_row_slack(row, belief, positions) < 0:
            found.append(f"row {row} on {rows.i[row]}, {rows.j[row]} by {belief.sources[int(rows.source[row])]}")
    if (positions < belief.polytope.lower).any() or (positions > belief.polytope.upper).any():
        found.append("box")
    for robot, region in enumerate(belief.regions):
        outer = region.outer
        for edge in range(len(outer.offsets)):
            if exact_slack(outer.normals[edge], outer.offsets[edge], positions[robot]) < 0:
                found.append(f"edge {edge} of robot {robot}: {', '.join(map(str, belief.causes(robot, edge)))}")
        if outside_hull(outer, positions[robot]):
            found.append(f"hull of robot {robot}'s vertices")
    if headings is not None and not belief.headings.contains(headings).all():
        found.append("headings")
    return found


def outside_hull(polygon: Polygon, point: Array) -> bool:
    """Return whether a point is farther than the margin from the hull of the vertices, for sure."""
    corners = polygon.vertices - point
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(*edges.T)
    crossed = corners[:, 0] * np.roll(corners[:, 1], -1) - corners[:, 1] * np.roll(corners[:, 0], -1)
    rounding = 1e-15 * (1 + np.abs(polygon.vertices).max()) * (np.abs(corners).sum(axis=1) + lengths)
    long = lengths > 0
    beside = (crossed < -rounding - polygon.margin * lengths)[long].any()
    widest = np.maximum(polygon.vertices.min(axis=0) - point, point - polygon.vertices.max(axis=0)).max()
    return bool(beside or widest > polygon.margin)


def random_program(
    rng: np.random.Generator, robots: int = 2, rows: int = 12, size: float = 1.0, origin: float = 0.0
) -> LinearProgram:
    """Return a program of rows on single robots and on pairs with the origin of its box, at least, inside."""
    count = 2 * robots
    A = np.zeros((rows, count))
    for row in range(rows):
        normal = unit(rng.uniform(-np.pi, np.pi))
        j = rng.integers(robots)
        A[row, 2 * j : 2 * j + 2] = normal
        i = rng.integers(-1, robots)
        if i not in (-1, j):
            A[row, 2 * i : 2 * i + 2] = -normal
    middle = np.full(count, origin)
    b = A @ middle + size * rng.uniform(0.1, 1.0, rows)
    return LinearProgram(sparse.csr_array(A), b, middle - size, middle + size)


def unit(angle: float | Array) -> Array:
    """Return the unit vector(s) of an angle, (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def feasible(program: LinearProgram, point: Array) -> bool:
    """Return whether a point (v,) is in the program without any rounding."""
    if (point < program.lower).any() or (point > program.upper).any():
        return False
    A = program.A.toarray()
    return all(exact_slack(A[row], program.b[row], point) >= 0 for row in range(len(A)))


def of_robot(polytope, robot):
    """Return a polygon around one robot, from its own rows alone, and the row behind each edge."""
    return single(polytope.of_robots(np.array([robot])))


def of_pair(polytope, i, j):
    """Return a polygon around x_j - x_i, from the pair's rows alone, and the row behind each edge."""
    return single(polytope.of(np.array([i]), np.array([j])))


def single(clipped):
    """Return the one polygon, and what is behind each of its edges."""
    return clipped.polygons[0], clipped.behind
