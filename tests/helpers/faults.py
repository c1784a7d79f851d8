"""Worlds in which one thing is false, and whether what a filter names is a conflict: built anew, by other means than its."""

from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
from helpers.programs import with_records
from helpers.worlds import claims_of, exact_claim, unit

from filter import (
    AngularIntervals,
    Bearing,
    Belief,
    Compass,
    Inconsistent,
    Odometry,
    Polygon,
    Range,
    SetMembershipFilter,
    Source,
    Stop,
    Team,
    Window,
)
from filter.linear.constraints import WORLD
from filter.projection.team import Projector

DEGREE = np.pi / 180
LANDMARKS = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, -1.0]])
ARENA = np.array([[-6.0, -6.0], [6.0, 6.0]])
SPEED, TURN_RATE, DURATION = 0.5, 1.0, 0.4
AT_ONCE = ("initial set", "heading", "compass", "bearing", "range", "arena")
LATER = ("compass", "bearing", "range", "odometry", "speed limit", "turn limit", "arena")
NO_ARENA = Polygon.box([-1e4, -1e4], [1e4, 1e4])


@dataclass
class Faulty:
    """Robots among landmarks; all that is declared of them holds, but for one thing: a kind of source, of one robot.

    The last robot has no odometry. `step` returns what a filter is given next; the last one has the fault.
    """

    rng: np.random.Generator
    fault: str
    robots: int = 1
    sensors: tuple[str, ...] = ("compass", "bearing", "range")
    options: dict[str, object] = field(default_factory=dict)
    strength: float = 1.0
    time: float = 0.0

    def __post_init__(self) -> None:
        # A limit is a robot's without odometry, and odometry one's with.
        self.bad = int(self.rng.integers(self.robots))
        if "limit" in self.fault:
            self.bad = self.robots - 1
        self.silent = {self.robots - 1} if self.robots > 1 or "limit" in self.fault else set()
        if self.fault in ("odometry", "arena"):
            self.bad = int(self.rng.integers(max(1, self.robots - 1)))
        self.positions, self.headings = self.rng.uniform(-3.5, 3.5, (self.robots, 2)), self.rng.uniform(-3, 3, self.robots)
        if self.fault == "arena":
            self.positions[self.bad, 0] = 5.9
        self.team = Team(self.robots, LANDMARKS, SPEED, TURN_RATE, ARENA)
        self.filter = SetMembershipFilter(self.team, **self.options)
        self.about: int | None = None  # the target of the measurement that is false

    def start(self, faulty: bool) -> Belief:
        wrong = faulty and self.fault == "initial set"
        if faulty and self.fault == "arena":
            self.positions[self.bad, 0] = 6.4 + 0.5 * self.strength
        self.then = self.positions.copy(), self.headings.copy()
        sets = [Polygon.box(x - self.rng.uniform(0.2, 0.8, 2), x + self.rng.uniform(0.2, 0.8, 2)) for x in self.positions]
        if faulty and self.fault == "arena":
            sets[self.bad] = Polygon.box(self.positions[self.bad] - 1, self.positions[self.bad] + 0.5)
        if wrong:
            there = self.positions[self.bad] + (0.6 + 1.2 * self.strength) * unit(self.rng.uniform(-3, 3))
            sets[self.bad] = Polygon.box(there - 0.4, there + 0.4)
        centre = self.headings + self.rng.uniform(-0.2, 0.2, self.robots)
        if faulty and self.fault == "heading":
            centre[self.bad] += 0.4 + 0.3 * self.strength
        self.sets, self.arcs = sets, AngularIntervals(centre, np.full(self.robots, 0.2))
        return self.filter.start(self.time, sets, self.arcs)

    def move(self, faulty: bool) -> Odometry | None:
        """Drive arcs without slip; of the last robot nobody measures how."""
        n, start, self.then = self.robots, self.time, (self.positions.copy(), self.headings.copy())
        distance, turn = self.rng.uniform(0, SPEED * DURATION, n), self.rng.uniform(-TURN_RATE, TURN_RATE, n) * DURATION
        jump = np.zeros((n, 2))
        if faulty and self.fault == "turn limit":
            turn[self.bad] += 0.8 + self.strength
        if faulty and self.fault == "speed limit":
            jump[self.bad] = (0.6 + 1.4 * self.strength) * unit(self.rng.uniform(-3, 3))
        if self.fault == "arena":
            jump[self.bad, 0] = (6.4 + 0.5 * self.strength if faulty else 5.9) - self.positions[self.bad, 0]
            distance[self.bad] = turn[self.bad] = 0.0
        chord, way = distance * np.sinc(turn / 2 / np.pi), self.headings + turn / 2
        self.positions = self.positions + chord[:, None] * unit(way) + jump
        self.headings, self.time = self.headings + turn, start + DURATION
        told, turned, slip = distance + 0.01 * self.error(n), turn + 0.02 * self.error(n), np.full(n, 0.01)
        if self.fault == "arena":
            slip[self.bad] = 1.0
        if faulty and self.fault == "odometry":
            if self.rng.random() < 0.5:
                told[self.bad] += (0.1 + 1.4 * self.strength) * self.rng.choice([-1, 1])
            else:
                turned[self.bad] += (0.1 + 0.7 * self.strength) * self.rng.choice([-1, 1])
        who = np.array([k for k in range(n) if k not in self.silent], dtype=int)
        if not len(who):
            return None
        return Odometry(start, self.time, who, told[who], 0.01, turned[who], 0.02, 1e-9, slip[who])

    def measure(self, faulty: bool) -> list[Compass | Bearing | Range]:
        """Return single records, in any order, of every robot to everybody and every landmark."""
        bodies, records = np.concatenate([self.positions, LANDMARKS]), []
        wrong = [k for k in range(len(bodies)) if k != self.bad]
        self.about = int(self.rng.choice(wrong)) if faulty and self.fault in ("bearing", "range") else None
        for k in range(self.robots):
            bad = faulty and k == self.bad
            lie = (0.1 + 0.5 * self.strength) * self.rng.choice([-1, 1]) * (bad and self.fault == "compass")
            records.append(Compass(self.time, k, self.headings[k] + 2 * DEGREE * self.error() + lie, 2 * DEGREE))
            for j in (j for j in range(len(bodies)) if j != k):
                apart, lies = bodies[j] - self.positions[k], bad and j == self.about
                turned = (0.1 + 0.4 * self.strength) * (lies and self.fault == "bearing")
                way = np.arctan2(apart[1], apart[0]) - self.headings[k] + 2 * DEGREE * self.error() + turned
                records.append(Bearing(self.time, k, j, way, 2 * DEGREE))
                longer = (0.3 + 1.2 * self.strength) * (lies and self.fault == "range")
                shown = max(0.0, np.hypot(*apart) + 0.1 * self.error() + longer)
                records.append(Range(self.time, k, j, shown, 0.1, 0.0))
        kinds = {**dict.fromkeys(self.sensors), self.fault: None}
        few = [record for record in records if type(record).__name__.lower() in kinds]
        return [few[k] for k in self.rng.permutation(len(few))]

    def error(self, size: int | None = None):
        """Return errors within +-1, now and then just as large."""
        drawn = self.rng.uniform(-1, 1, size)
        return np.where(self.rng.random(size) < 0.2, 0.999 * np.sign(drawn), drawn)

    def is_guilty(self, source: Source) -> bool:
        return (source.kind, source.robot, source.target) == (self.fault, self.bad, self.about)


@dataclass
class Case:
    """What was known before, the motion, the measurements, and what the filter named."""

    world: Faulty
    before: Belief
    motion: tuple[float, Odometry | None] | None
    records: list[Compass | Bearing | Range]
    named: tuple[Source, ...]

    def excluded(self, sources: tuple[Source, ...]) -> bool:
        """Return whether these sources alone, of robots that can be anywhere, are proved to exclude one another.

        The filter is asked through its own door, in an open arena: who is in the arena is put in a smaller box.
        """
        try:
            self.filter.update(*self._alone(sources))
        except Inconsistent:
            return True
        return False

    def exact_gap(self, sources: tuple[Source, ...]) -> Fraction | None:
        """Return what a certificate of that proves, below 0 if it is one, without any rounding; None where arcs or boxes do."""
        try:
            polytope = with_records(self.filter, *self._alone(sources))
        except Inconsistent:
            return None
        weights = Projector(Window.everybody(), Stop(), True, ("piqp", "highs")).robots(polytope).contradiction
        nothing = np.zeros((1, 2)), np.zeros(1)
        rows = np.arange(len(weights))[None]
        return exact_claim(claims_of(polytope, (np.array([WORLD]), np.array([0])), nothing, (rows, weights[None])), 0)

    @property
    def filter(self) -> SetMembershipFilter:
        """The filter in an open arena."""
        return replace(self.world.filter, policy="raise", team=replace(self.world.team, arena=[[-np.inf] * 2, [np.inf] * 2]))

    def is_false(self, source: Source) -> bool:
        """Return whether what was known before the motion is false, as something went wrong earlier."""
        (positions, headings), robot, rows = self.world.then, source.robot, self.before.constraints
        if source.kind == "heading":
            return not self.before.headings.contains(headings)[robot]
        if source.kind not in ("initial set", "region", "pair"):
            return False
        mutual = source.kind == "pair"
        own = rows.rows_of(robot, source.target) if mutual else rows.rows_of(WORLD, robot)
        place = positions[source.target] - positions[robot] if mutual else positions[robot]
        lower, upper = self.before.polytope.lower[robot], self.before.polytope.upper[robot]
        outside = not mutual and bool(((place < lower) | (place > upper)).any())
        return outside or bool((rows.normal[own] @ place > rows.offset[own]).any())

    def _alone(self, sources: tuple[Source, ...]) -> tuple[Belief, list[Compass | Bearing | Range]]:
        held = {(each.kind, each.robot, each.target) for each in sources}
        of = lambda kind: np.array([(kind, robot, None) in held for robot in range(self.world.robots)])  # noqa: E731
        belief = self._moved(self.filter, self._placed(self.filter, held, of), of)
        return _within(belief, of("arena")), [record for record in self.records if key_of(record) in held]

    def _placed(self, filter_, held, of) -> Belief:
        stays = np.full(self.world.robots, self.motion is None)
        moved, turned = (of("odometry") | of(limit) | stays for limit in ("speed limit", "turn limit"))
        sets = moved & (of("initial set") | of("region"))
        regions = self.world.sets if self.before.found is None else [region.outer for region in self.before.regions]
        polygons = [region if known else NO_ARENA for region, known in zip(regions, sets, strict=True)]
        bound = np.where(of("heading") & turned, self.before.headings.bound, np.pi)
        belief = filter_.start(self.before.time, polygons, AngularIntervals(self.before.headings.centre, bound))
        rows = self.before.constraints
        keep = [("pair", i, j) in held and moved[i] and moved[j] for i, j in zip(rows.i.tolist(), rows.j.tolist(), strict=True)]
        pairs = rows.select(np.flatnonzero(np.array(keep, dtype=bool) & (rows.i != WORLD)))
        both = type(rows).concatenate([belief.constraints, replace(pairs, source=np.zeros(len(pairs), dtype=int))])
        slices = self.before.slices.without(np.flatnonzero(~(sets & of("heading") & turned & of("arena"))))
        polytope = belief.polytope.with_constraints(both)
        belief = replace(belief, polytope=polytope, proofs=self.before.proofs, slices=slices)
        return _within(belief, of("arena") & moved)

    def _moved(self, filter_, belief, of) -> Belief:
        if self.motion is None:
            return belief
        time, odometry = self.motion
        if odometry is not None:
            told = np.array([of("odometry")[robot] for robot in odometry.robot.tolist()])
            columns = {
                name: getattr(odometry, name)[told] for name in odometry.__dataclass_fields__ if name not in ("start", "time")
            }
            odometry = replace(odometry, **columns)
        return filter_.predict(belief, time, odometry)


def _within(belief, inside):
    """Return the belief with some robots (n,) in the arena."""
    polytope = belief.polytope
    lower = np.where(inside[:, None], np.maximum(polytope.lower, ARENA[0]), polytope.lower)
    upper = np.where(inside[:, None], np.minimum(polytope.upper, ARENA[1]), polytope.upper)
    if (lower > upper).any():
        raise Inconsistent("a robot is outside the arena", [])
    return replace(belief, polytope=replace(polytope, lower=lower, upper=upper))


def key_of(record):
    target = None if isinstance(record, Compass) else int(record.target[0])
    return type(record).__name__.lower(), int(record.robot[0]), target


def conflicting(world: Faulty, steps: int) -> Case | None:
    """Let a filter follow a world to its fault, after so many steps without; return the conflict, or None if there is none."""
    belief = world.start(faulty=steps == 0)
    if steps == 0:
        return attempted(world, belief, None)
    belief = world.filter.update(belief, world.measure(False))
    for _ in range(steps - 1):
        odometry = world.move(False)
        belief = world.filter.update(world.filter.predict(belief, world.time, odometry), world.measure(False))
    odometry = world.move(True)
    return attempted(world, belief, (world.time, odometry))


def conflicting_later(world: Faulty, steps: int = 8) -> Case | None:
    """Let a filter follow a world with few measurements, in which something goes wrong early; return the first conflict."""
    fault = 0 if world.fault in ("initial set", "heading") else 1
    belief, about = world.start(faulty=fault == 0), None
    for step in range(steps):
        motion = (world.time + DURATION, world.move(step == fault)) if step else None
        records = world.measure(step == fault)
        about = about if world.about is None else world.about
        records = [record for record in records if step == fault or world.rng.random() < 0.2]
        before = belief
        try:
            belief = world.filter.update(world.filter.predict(before, *motion) if motion else before, records)
        except Inconsistent as error:
            world.about = about
            return Case(world, before, motion, records, error.sources)
    return None


def attempted(world: Faulty, before: Belief, motion: tuple[float, Odometry | None] | None) -> Case | None:
    """Merge what has the fault."""
    records = world.measure(True)
    try:
        belief = world.filter.predict(before, *motion) if motion else before
        world.filter.update(belief, records)
    except Inconsistent as error:
        return Case(world, before, motion, records, error.sources)
    return None
