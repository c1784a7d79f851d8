"""Reads a run of the UTIAS multi-robot data set (MRCLAM): tables of commands, measurements and truth, as they were logged.

K. Leung, Y. Halpern, T. Barfoot, H. Liu, The UTIAS Multi-Robot Cooperative Localization and Mapping Dataset, International
Journal of Robotics Research 30(8), 2011. A run is a folder: `Robot<k>_Odometry.dat`, `Robot<k>_Measurement.dat` and, where
there is truth, `Robot<k>_Groundtruth.dat` for every robot k; `Barcodes.dat`; `Landmark_Groundtruth.dat`. What these mean to
a filter is in `experiments.mrclam_frames`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from filter.arrays import Array, read_only
from filter.errors import InvalidInput

ODOMETRY = re.compile(r"Robot(\d+)_Odometry\.dat")
DECIMALS = 6  # of times since the run's start [s]; the logs have three


@dataclass(frozen=True, eq=False)
class RobotLog:
    """What one robot logged, in order of time, times counted from the run's start.

    Attributes:
        commands: (c, 3) time [s], forward speed [m/s] and turn rate [rad/s] that the robot was told from then on.
        measurements: (m, 4) time [s], subject, range [m] and bearing [rad] from the robot's forward axis.
        truth: (g, 4) time [s], x [m], y [m], heading [rad]; no rows where there is no file.
    """

    commands: Array
    measurements: Array
    truth: Array

    def __post_init__(self) -> None:
        for name in ("commands", "measurements", "truth"):
            object.__setattr__(self, name, read_only(getattr(self, name)))


@dataclass(frozen=True)
class Dropped:
    """What of the files could not be used.

    Attributes:
        cut_lines: Last lines that are not whole.
        unknown_barcodes: Measurements of a barcode that names nobody, or the robot itself.
        duplicates: Measurements that say the same as another one, bit for bit.
        impossible: Measurements of a negative range.
    """

    cut_lines: int = 0
    unknown_barcodes: int = 0
    duplicates: int = 0
    impossible: int = 0

    def __add__(self, other: Dropped) -> Dropped:
        return Dropped(*(mine + theirs for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True)))


@dataclass(frozen=True, eq=False)
class Run:
    """A run of the data set.

    Attributes:
        name: The folder's name.
        epoch: The first command or measurement of anybody, on the logs' clock; times are counted from here [s].
        logs: Of each robot, by its number in the files.
        landmarks: (l, 3) subject, x [m], y [m].
        dropped: What could not be used.
    """

    name: str
    epoch: float
    logs: Mapping[int, RobotLog]
    landmarks: Array
    dropped: Dropped = field(default_factory=Dropped)

    @property
    def end(self) -> float:
        """The time of the last command or measurement [s]."""
        return max((float(log[-1, 0]) for log in self._stamped()), default=0.0)

    def _stamped(self) -> list[Array]:
        return [table for log in self.logs.values() for table in (log.commands, log.measurements) if len(table)]


def read_run(folder: Path) -> Run:
    """Return the run in a folder.

    A last line that is cut off is normal and left out; so is a barcode that names nobody. Both are counted.

    Raises:
        InvalidInput: A file is missing (but one of truth), or a line is damaged; the message has the file and the line.
    """
    barcodes, landmarks = _subjects(folder / "Barcodes.dat"), _table(folder / "Landmark_Groundtruth.dat", 5, whole=True)[0]
    robots = sorted(int(named[1]) for path in folder.glob("*") if (named := ODOMETRY.fullmatch(path.name)))
    if not robots:
        raise InvalidInput(f"logs of robots in {folder}", "no file Robot<k>_Odometry.dat")
    read = {robot: _log(folder, robot, barcodes) for robot in robots}
    logs, dropped = {robot: log for robot, (log, _) in read.items()}, sum((less for _, less in read.values()), Dropped())
    begun = [table[0, 0] for log in logs.values() for table in (log.commands, log.measurements) if len(table)]
    if not begun:
        raise InvalidInput(f"commands or measurements in {folder}", "none")
    epoch = float(min(begun))
    since = {robot: _since(log, epoch) for robot, log in logs.items()}
    return Run(folder.resolve().name, epoch, since, read_only(landmarks[np.argsort(landmarks[:, 0])][:, :3]), dropped)


def _subjects(path: Path) -> dict[int, int]:
    """Return the subject that each barcode names."""
    return {int(barcode): int(subject) for subject, barcode in _table(path, 2, whole=True)[0]}


def _log(folder: Path, robot: int, barcodes: Mapping[int, int]) -> tuple[RobotLog, Dropped]:
    """Return a robot's log on the logs' clock, and what could not be used."""
    commands, cut = _table(folder / f"Robot{robot}_Odometry.dat", 3)
    measurements, cut_too = _table(folder / f"Robot{robot}_Measurement.dat", 4)
    where = folder / f"Robot{robot}_Groundtruth.dat"
    truth, cut_as_well = _table(where, 4) if where.exists() else (np.zeros((0, 4)), 0)
    named, dropped = _named(measurements, robot, barcodes)
    first = np.unique(truth[:, 0], return_index=True)[1]
    log = RobotLog(_in_order(commands), _in_order(named), truth[first])
    return log, replace(dropped, cut_lines=cut + cut_too + cut_as_well)


def _named(measurements: Array, robot: int, barcodes: Mapping[int, int]) -> tuple[Array, Dropped]:
    """Return the measurements with subjects in place of barcodes, and how many were dropped."""
    subjects = np.array([barcodes.get(int(barcode), robot) for barcode in measurements[:, 1]])
    known, possible = subjects != robot, measurements[:, 2] >= 0
    named = np.column_stack([measurements[:, 0], subjects, measurements[:, 2:]])[known & possible]
    once = np.sort(np.unique(named, axis=0, return_index=True)[1])
    return named[once], Dropped(
        unknown_barcodes=int((~known).sum()), duplicates=len(named) - len(once), impossible=int((known & ~possible).sum())
    )


def _in_order(table: Array) -> Array:
    return table[np.argsort(table[:, 0], kind="stable")]


def _since(log: RobotLog, epoch: float) -> RobotLog:
    def shifted(table: Array) -> Array:
        return np.column_stack([np.round(table[:, 0] - epoch, DECIMALS), table[:, 1:]])

    return RobotLog(shifted(log.commands), shifted(log.measurements), shifted(log.truth))


def _table(path: Path, columns: int, whole: bool = False) -> tuple[Array, int]:
    """Return (k, columns) the numbers of a file, and whether (0 or 1) its last line was cut off and left out.

    Args:
        path: Of the file; what follows a # is a comment.
        columns: How many numbers a line has.
        whole: The file was not logged but written at once: a last line without an end is whole if it has all its numbers.
    """
    try:
        lines = path.read_bytes().decode("ascii", errors="replace").splitlines(keepends=True)
    except OSError as error:
        raise InvalidInput("a readable file", f"{path}: {error.strerror}") from None
    cut = bool(lines) and _cut(lines[-1], columns, whole)
    lines = lines[:-1] if cut else lines
    if not any(_words(line) for line in lines):
        return np.zeros((0, columns)), int(cut)
    try:
        table = np.loadtxt(lines, ndmin=2)
    except ValueError:
        table = np.zeros((0, 0))
    if table.shape[1] != columns or not np.isfinite(table).all():
        raise _damage(path, lines, columns)
    return table, int(cut)


def _cut(line: str, columns: int, whole: bool) -> bool:
    """Return whether a last line is cut off; without its end, its last number may have lost digits."""
    words = _words(line)
    return bool(words) and (not _numbers(words, columns) or not (whole or line.endswith("\n")))


def _damage(path: Path, lines: list[str], columns: int) -> InvalidInput:
    """Return the error that names the first line at fault."""
    numbered = ((number, _words(line)) for number, line in enumerate(lines, 1))
    number = next(number for number, words in numbered if words and not _numbers(words, columns))
    return InvalidInput(f"{path}, line {number}: {columns} finite numbers", repr(lines[number - 1].strip()))


def _words(line: str) -> list[str]:
    return line.split("#", 1)[0].split()


def _numbers(words: list[str], columns: int) -> bool:
    try:
        return len(words) == columns and bool(np.isfinite([float(word) for word in words]).all())
    except ValueError:
        return False
