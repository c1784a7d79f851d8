"""A run of the MRCLAM data set as frames, as the simulator gives them: each measurement at its own time, nothing resampled.

There is a frame at every time at which some robot of the team measured, with the motion of all robots since the frame before.
The truth is for judging only. What a filter is told of the start is one declared set a robot.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.following.frozen import keep_within
from experiments.following.scenarios import CORNERS, Scenario
from experiments.logs import Header, InitialSet
from experiments.real_robots.bounds import DEGREE, Bounds
from experiments.real_robots.data import DECIMALS, Run
from experiments.real_robots.motion import Motion, Motions
from filter import Array, Bearing, Frame, Integers, InvalidInput, Mask, Measurement, Odometry, Range, Team, Truth, wrap

ARENA_MARGIN = 4.0  # how far outside the landmarks' box a robot may be [m]
TRUTH_GAP = 0.1  # between two poses farther apart than this nobody knows where a robot was [s]


@dataclass(frozen=True)
class Start:
    """What is known of each robot when a run starts: it was put down near a known pose.

    Attributes:
        position: Half the side of a square around the true position [m], or None: anywhere in the arena.
        heading: Half-width of the arc around the true heading [rad], or None: any heading.
    """

    position: float | None = 0.5
    heading: float | None = 30 * DEGREE

    def __post_init__(self) -> None:
        keep_within(self, position=(0, np.inf), heading=(0, np.pi))

    def widened(self, bounds: Bounds) -> Start:
        """Return what is known of the pose that a belief follows: the jitters of the bounds added."""
        position = None if self.position is None else self.position + bounds.position_jitter
        heading = None if self.heading is None else min(self.heading + bounds.heading_jitter, np.pi)
        return Start(position, heading)


def frames(
    run: Run,
    robots: Sequence[int] = (1, 2, 3, 4, 5),
    start: float = 0.0,
    duration: float | None = None,
    *,
    bounds: Bounds | None = None,
    known: Start | None = None,
    generator: np.random.Generator | None = None,
) -> Scenario:
    """Return a run as a scenario: team, initial sets, frames.

    Args:
        run: As it was read.
        robots: Numbers in the files of those that take part; they become robots 0, 1, ..., the landmarks n, n + 1, ...
            by their number. What the others measured, and what was measured of them, is left out.
        start: When the scenario starts, since the run's epoch [s].
        duration: How long it lasts at most [s]; None for all there is.
        bounds: The declared bounds; the defaults if None.
        known: What is known at the start; the defaults if None. It is where the truth enters, and the only place. A robot
            whose truth is not known at the start may be anywhere, with any heading.
        generator: Moves each initial set at random as far as it still contains the truth; None leaves the truth in its middle.

    Raises:
        InvalidInput: A robot has no log or comes twice, or there is no measurement in this time.
    """
    bounds, known = bounds or Bounds(), known or Start()
    _check_robots(run, robots)
    team = team_of(run, len(robots), bounds)
    end = np.inf if duration is None else start + duration
    if not 0 <= start <= end:
        raise InvalidInput("a start from 0 s on, and a duration from 0 s on", f"{start} s and {duration} s")
    measured = Readings.of(run, robots, bounds).between(start, end)
    if not len(measured.time):
        raise InvalidInput(f"measurements of robots {list(robots)} from {start} s to {end} s", "none")
    times = np.unique(measured.time)
    truth = truth_at(run, robots, np.append(start, times))
    return Scenario(
        header=Header(team, start, None),
        initial=_initial_sets(truth.positions[0], truth.headings[0], known.widened(bounds), team, generator),
        frames=_frames(start, times, measured, Motions(run, robots, bounds), truth),
        count=len(times),
        walls=np.zeros((0, 4)),
        wall_height=0.0,
        picture=None,
    )


def _check_robots(run: Run, robots: Sequence[int]) -> None:
    unknown = [robot for robot in robots if robot not in run.logs]
    if unknown or not robots or len(set(robots)) < len(robots):
        raise InvalidInput(f"different robots among {sorted(run.logs)}", list(robots))


def team_of(run: Run, robots: int, bounds: Bounds) -> Team:
    """Return the team: the arena is the landmarks' box and a margin, or without end where there are no landmarks."""
    places = run.landmarks[:, 1:]
    arena = np.array([[-np.inf] * 2, [np.inf] * 2])
    if len(places):
        arena = np.array([places.min(axis=0) - ARENA_MARGIN, places.max(axis=0) + ARENA_MARGIN])
    speed, rate = (knots[0][1] / knots[0][0] for knots in (bounds.reach, bounds.swing))
    return Team(robots, places, speed_limit=speed, turn_rate_limit=rate, arena=arena)


@dataclass(frozen=True, eq=False)
class Readings:
    """What the robots of a team measured, in order of time.

    Attributes:
        time: (m,) when it was measured, its delay taken off [s].
        robot: (m,) who, by number in the team.
        target: (m,) what, by number in the team.
        range: (m,) [m].
        range_bound: (m,) absolute [m].
        relative_range_bound: (m,).
        bearing: (m,) [rad].
        bearing_bound: (m,) [rad].
        left_out: How many measurements were of robots that do not take part, or of landmarks that are nowhere.
    """

    time: Array
    robot: Integers
    target: Integers
    range: Array
    range_bound: Array
    relative_range_bound: Array
    bearing: Array
    bearing_bound: Array
    left_out: int

    @classmethod
    def of(cls, run: Run, robots: Sequence[int], bounds: Bounds) -> Readings:
        """Return all that some robots measured of one another and of the landmarks."""
        bodies = {subject: k for k, subject in enumerate([*robots, *run.landmarks[:, 0].astype(int).tolist()])}
        tables = [run.logs[robot].measurements for robot in robots]
        table = np.concatenate(tables)
        robot = np.repeat(np.arange(len(robots)), [len(each) for each in tables])
        target = np.array([bodies.get(int(subject), -1) for subject in table[:, 1]], dtype=np.int64)
        time = np.round(table[:, 0] - bounds.measurement_delay, DECIMALS)
        columns = (time, robot, target, table[:, 2], *bounds.range_columns(table[:, 2]), table[:, 3])
        every = cls(*columns, np.full(len(time), bounds.bearing), int((target < 0).sum()))
        order = np.lexsort((robot, time))
        return every._select(order[target[order] >= 0])

    def between(self, start: float, end: float) -> Readings:
        """Return the readings after `start` and up to `end` [s]."""
        return self._select(np.flatnonzero((self.time > start) & (self.time <= end)))

    def at(self, index: slice, time: float) -> tuple[Measurement, ...]:
        """Return the records of some readings, all of one time."""
        names = ("robot", "target", "range", "range_bound", "relative_range_bound", "bearing", "bearing_bound")
        robot, target, distance, absolute, relative, bearing, bound = (getattr(self, name)[index] for name in names)
        return (
            Bearing(time=time, robot=robot, target=target, bearing=bearing, bound=bound),
            Range(time=time, robot=robot, target=target, range=distance, bound=absolute, relative_bound=relative),
        )

    def _select(self, index: Integers) -> Readings:
        return replace(self, **{name: column[index] for name, column in vars(self).items() if name != "left_out"})


def truth_at(run: Run, robots: Sequence[int], times: Array) -> TruthTable:
    """Return the truth of some robots at some times (k,) [s], by interpolation; NaN where there is a gap or no truth."""
    columns = [_poses(run.logs[robot].truth, times) for robot in robots]
    poses = np.stack(columns, axis=1)
    return TruthTable(poses[:, :, :2], wrap(poses[:, :, 2]))


@dataclass(frozen=True, eq=False)
class TruthTable:
    """The truth at k times.

    Attributes:
        positions: (k, n, 2) [m].
        headings: (k, n) [rad].
    """

    positions: Array
    headings: Array


def _poses(table: Array, times: Array) -> Array:
    """Return (k, 3) x, y and heading (unwrapped) at the times."""
    poses = np.full((len(times), 3), np.nan)
    if len(table) < 2:
        return poses
    known = _known(table[:, 0], times)
    for column, values in enumerate((table[:, 1], table[:, 2], np.unwrap(table[:, 3]))):
        poses[known, column] = np.interp(times[known], table[:, 0], values)
    return poses


def _known(stamps: Array, times: Array) -> Mask:
    after = np.clip(np.searchsorted(stamps, times), 1, len(stamps) - 1)
    within = (stamps[0] <= times) & (times <= stamps[-1])
    near = (stamps[after] - stamps[after - 1] <= TRUTH_GAP) | (stamps[after] == times)
    return np.asarray(within & near)


def _initial_sets(
    positions: Array, headings: Array, known: Start, team: Team, generator: np.random.Generator | None
) -> tuple[InitialSet, ...]:
    lower, upper = team.arena
    anywhere = (lower + upper) / 2 + (upper - lower) / 2 * CORNERS
    aside = np.zeros((len(positions), 3)) if generator is None else generator.uniform(-1, 1, (len(positions), 3))
    sets = []
    for place, heading, by in zip(positions, headings.tolist(), aside, strict=True):
        box, arc = anywhere, None
        if known.position is not None and np.isfinite(place).all():
            box = place + known.position * (by[:2] + CORNERS)
        if known.heading is not None and np.isfinite(heading):
            arc = (float(wrap(heading + known.heading * by[2])), known.heading)
        sets.append(InitialSet(box, arc))
    return tuple(sets)


def _frames(start: float, times: Array, measured: Readings, motions: Motions, truth: TruthTable) -> Iterator[Frame]:
    """Yield a frame a time; row 0 of the truth is that of the start."""
    robots = np.arange(truth.headings.shape[1])
    begin = np.append(start, times[:-1])
    moves = Motion.stacked([motions.motion(int(robot), begin, times) for robot in robots]).odometry_columns()
    first, last = (np.searchsorted(measured.time, times, side=side).tolist() for side in ("left", "right"))
    for k, (since, time) in enumerate(zip(begin.tolist(), times.tolist(), strict=True)):
        odometry = Odometry(start=since, time=time, robot=robots, **{name: column[k] for name, column in moves.items()})
        records = measured.at(slice(first[k], last[k]), time)
        yield Frame(time, odometry, records, Truth(truth.positions[k + 1], truth.headings[k + 1]))
