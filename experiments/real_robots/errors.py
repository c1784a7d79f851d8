"""The errors of a run whose truth is known: of sensors, of motion, of clocks. Nothing of this is used while a filter runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.following.frozen import freeze
from experiments.following.metrics import rounded
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.data import Run
from experiments.real_robots.frames import Readings, truth_at
from experiments.real_robots.motion import Motions
from filter import Array, Bearing, Compass, Frame, Integers, Mask, Odometry, Position, Range, RelativeHeading, Team, Truth, wrap

LENGTHS = (0.1, 1.0, 10.0)  # of the intervals in which motion is judged [s]
ROUNDING = 1e-9  # an error that is at its bound does not break it [m] [rad]
NO_REACH = ((1.0, 1e3),)  # knots of a path without limit
EVERY = 0.05  # between the beginnings of such intervals [s]
DELAYS = np.arange(-0.1, 0.301, 0.02)  # that are tried [s]


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of one kind of sensor, against the truth.

    Attributes:
        kind: "range" [m], "bearing", "compass" [rad], or of motion: "path", "slip" [m], "turn" [rad], with its interval.
        robot: (k,) whose.
        time: (k,) [s].
        error: (k,) said less true.
        true: (k,) the true value.
        broken: (k,) whether the error is beyond the declared bound.
    """

    kind: str
    robot: Integers
    time: Array
    error: Array
    true: Array
    broken: Mask

    def __post_init__(self) -> None:
        freeze(self)

    def of(self, chosen: Mask) -> Errors:
        """Return some of them."""
        columns = (getattr(self, name)[chosen] for name in ("robot", "time", "error", "true", "broken"))
        return Errors(self.kind, *columns)


def sensor_errors(frames: Iterable[Frame], team: Team) -> list[Errors]:
    """Return the errors of all measurements and of the odometry since the frame before, kind by kind, where truth is known.

    A frame's odometry is judged by its turn alone: the way of a robot between two frames is not known to a log. Positions have
    no error that could be told from their bound, and are left out;
    so are mates' headings, as yet. Errors are those against what a sensor where it is mounted
    would say at the stamp; a bound is broken if the sensor's mounting and its clock do not explain it either.
    """
    rows: dict[str, list[Array]] = {}
    before: Truth | None = None
    for frame in frames:
        if frame.truth is not None:
            for record in (each for each in frame.measurements if not isinstance(each, Position | RelativeHeading)):
                rows.setdefault(type(record).__name__.lower(), []).append(_measured(record, frame.truth, team))
            if frame.odometry is not None and before is not None:
                rows.setdefault("turn", []).append(_turned(frame.odometry, before, frame.truth))
        before = frame.truth
    return [_errors(kind, np.concatenate(parts)) for kind, parts in sorted(rows.items())]


def _errors(kind: str, table: Array) -> Errors:
    known = table[np.isfinite(table[:, 2])]
    return Errors(kind, known[:, 0].astype(np.int64), known[:, 1], known[:, 2], known[:, 3], known[:, 4] > 0)


def _measured(record: Compass | Bearing | Range, truth: Truth, team: Team) -> Array:
    """Return (k, 5) robot, time, error, true value and whether the bound is broken."""
    mounted = team.mounted
    robot, sensor, looks = record.robot, record.sensor, truth.headings[record.robot] + mounted.angle[record.sensor]
    bound = record.bound + mounted.angle_bound[sensor] + mounted.swing[sensor, robot]
    if isinstance(record, Compass):
        return _angles(robot, record.time, record.heading, wrap(looks), bound)
    ends, sensors = (robot, record.target), (sensor, record.target_sensor)
    start, end = (_places(truth, team, *each) for each in zip(ends, (mounted.position[each] for each in sensors), strict=True))
    away, off = end - start, mounted.off(ends, sensors)
    distance = np.hypot(away[:, 0], away[:, 1])
    if isinstance(record, Bearing):
        aside = np.where(off < distance, np.arcsin(np.clip(off / np.maximum(distance, ROUNDING), 0, 1)), np.pi * (off > 0))
        return _angles(robot, record.time, record.bearing, wrap(np.arctan2(away[:, 1], away[:, 0]) - looks), bound + aside)
    least, greatest = record.interval()
    broken = (distance < least - off - ROUNDING) | (distance > greatest + off + ROUNDING)
    return np.column_stack([robot, np.full(len(away), record.time), record.range - distance, distance, broken])


def _places(truth: Truth, team: Team, body: Integers, position: Array) -> Array:
    """Return where sensors at positions (k, 2) on robots, or landmarks, (k,) really are, (k, 2) [m]."""
    way = np.append(truth.headings, np.zeros(len(team.landmarks)))[body]
    sine, cosine, (ahead, left) = np.sin(way), np.cos(way), position.T
    arm = np.stack([cosine * ahead - sine * left, sine * ahead + cosine * left], axis=1)
    arm[~position.any(axis=1)] = 0  # where the heading is not known, too
    return np.asarray(np.concatenate([truth.positions, team.landmarks])[body] + arm)


def _turned(odometry: Odometry, before: Truth, after: Truth) -> Array:
    true = wrap(after.headings - before.headings)[odometry.robot]
    return _angles(odometry.robot, odometry.time, odometry.turn, true, odometry.turn_bound)


def _angles(robot: Integers, time: float, said: Array, true: Array, bound: Array) -> Array:
    error = wrap(said - true)
    return np.column_stack([robot, np.full(len(robot), time), error, true, np.abs(error) > bound + ROUNDING])


def motion_errors(run: Run, robots: Sequence[int], bounds: Bounds) -> list[Errors]:
    """Return the errors of turn, path and slip over intervals of several lengths, from robots' commands, kind by kind.

    The path is the displacement along the mean heading, small pieces added up; the slip is what is across it. The longest
    path that is possible at all plays no part: it is not an error of the commands.
    """
    motions = Motions(run, robots, replace(bounds, reach=NO_REACH))
    found = []
    for length in LENGTHS:
        parts = [_motion_errors(run, robot, k, motions, length) for k, robot in enumerate(robots)]
        for kind in ("turn", "path", "slip"):
            found.append(_errors(f"{kind} over {length:g} s", np.concatenate([part[kind] for part in parts])))
    return found


def _motion_errors(run: Run, robot: int, index: int, motions: Motions, length: float) -> dict[str, Array]:
    truth = run.logs[robot].truth
    last = truth[-1, 0] if len(truth) else 0.0
    start = np.arange(0.0, max(last - length, 0.0), EVERY)
    path, slip, turn, unbroken = driven(run, robot, start, start + length)
    motion = motions.motion(index, start, start + length)
    scales = (("turn", motion.turn, turn, motion.turn_bound), ("path", motion.distance, path, motion.distance_bound))
    slack = motion.slip_bound  # a path may be off by the slip besides
    rows = {}
    for kind, said, true, bound in (*scales, ("slip", np.zeros(len(start)), slip, slack)):
        error = np.where(unbroken, said - true, np.nan)
        broken = np.abs(error) > bound + (slack if kind == "path" else 0.0)
        rows[kind] = np.column_stack([np.full(len(start), index), start, error, true, broken])
    return rows


def driven(run: Run, robot: int, start: Array, end: Array) -> tuple[Array, Array, Array, Mask]:
    """Return (k,) true path, slip [m] and turn [rad] in intervals (k,) [s], and whether the truth has no gap there."""
    clock = np.arange(0.0, end.max(initial=0.0) + EVERY / 2, EVERY)
    poses = truth_at(run, [robot], clock)
    places, headings = poses.positions[:, 0], poses.headings[:, 0]
    steps, turns = np.diff(places, axis=0), wrap(np.diff(headings))
    way = headings[:-1] + turns / 2
    along = steps[:, 0] * np.cos(way) + steps[:, 1] * np.sin(way)
    across = steps[:, 1] * np.cos(way) - steps[:, 0] * np.sin(way)
    first, last = (np.rint(times / EVERY).astype(np.int64) for times in (start, end))
    sums = [np.append(0.0, np.cumsum(np.nan_to_num(each))) for each in (along, across, turns, np.isnan(along))]
    path, slip, turn, gaps = (total[last] - total[first] for total in sums)
    return path, slip, turn, gaps == 0


def measurement_delay(run: Run, robot: int) -> float | None:
    """Return the delay at which a robot's bearings of landmarks fit the truth best [s], None where there are too few.

    Best is the least 90 % quantile of the errors about their median, which is a bias.
    """
    every = Readings.of(run, [robot], replace(Bounds(), measurement_delay=0.0))
    if not len(every.time) or not len(run.logs[robot].truth):
        return None
    marks = run.landmarks[every.target - 1, 1:]

    def misfit(delay: float) -> float:
        truth = truth_at(run, [robot], every.time - delay)
        away = marks - truth.positions[:, 0]
        error = wrap(every.bearing - np.arctan2(away[:, 1], away[:, 0]) + truth.headings[:, 0])
        known = error[np.isfinite(error)]
        return float(np.quantile(np.abs(wrap(known - np.median(known))), 0.9)) if len(known) else np.inf

    return _best(misfit)


def command_lag(run: Run, robot: int) -> float | None:
    """Return the lag at which a robot's commanded turns over half a second fit the true ones best [s], None without truth."""
    truth = run.logs[robot].truth
    if len(truth) < len(DELAYS):
        return None
    start = np.arange(1.0, truth[-1, 0] - 1.0, EVERY)
    _, _, turn, unbroken = driven(run, robot, start, start + 0.5)

    def misfit(lag: float) -> float:
        motions = Motions(run, [robot], replace(Bounds(), command_lag=max(lag, 0.0)))
        return float(np.mean(np.abs(motions.motion(0, start, start + 0.5).turn - turn)[unbroken]))

    return _best(misfit) if unbroken.any() else None


def _best(misfit: Callable[[float], float]) -> float:
    return rounded(float(min(DELAYS.tolist(), key=misfit)))


def speed_scale(run: Run, robot: int) -> float | None:
    """Return a robot's driven path over its commanded path, None without either."""
    truth = run.logs[robot].truth
    start = np.arange(0.0, truth[-1, 0] - 1.0 if len(truth) else 0.0, 1.0)
    path, _, _, unbroken = driven(run, robot, start, start + 1.0)
    wide = replace(Bounds(), speed_scale=1.0, reach=NO_REACH)
    commanded = Motions(run, [robot], wide).motion(0, start, start + 1.0).distance
    told = float(commanded[unbroken].sum())
    return rounded(float(path[unbroken].sum()) / told) if told > 0 else None
