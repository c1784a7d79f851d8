"""Reads a run of the UTIAS multi-robot data set (MRCLAM): tables of commands, measurements and truth, as they were logged.

K. Leung, Y. Halpern, T. Barfoot, H. Liu, The UTIAS Multi-Robot Cooperative Localization and Mapping Dataset, International
Journal of Robotics Research 30(8), 2011. A run is a folder: `Robot<k>_Odometry.dat`, `Robot<k>_Measurement.dat` and, where
there is truth, `Robot<k>_Groundtruth.dat` for every robot k; `Barcodes.dat`; `Landmark_Groundtruth.dat`. What these mean to
a filter is in `experiments.real_robots.frames`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from experiments.following.frozen import freeze
from experiments.logs import TextFile
from filter import Array, InvalidInput

ODOMETRY = re.compile(r"Robot(\d+)_Odometry\.dat")
DECIMALS = 6  # of times since the run's start [s]; the logs have three


@dataclass(frozen=True)
class Dropped:
    """What of a robot's files, or of all, could not be used.

    Attributes:
        cut_lines: Last lines that are not whole and were left out.
        unknown_barcodes: Measurements of a barcode that names nobody, or the robot itself.
        duplicates: Commands and measurements that say the same as another one, bit for bit.
        impossible: Measurements of a negative range.
    """

    cut_lines: int = 0
    unknown_barcodes: int = 0
    duplicates: int = 0
    impossible: int = 0

    def __add__(self, other: Dropped) -> Dropped:
        return Dropped(*(mine + theirs for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True)))


@dataclass(frozen=True, eq=False)
class RobotLog:
    """What one robot logged.

    Attributes:
        commands: (c, 3) time [s], forward speed [m/s] and turn rate [rad/s] that the robot was told from then on.
        measurements: (m, 4) time [s], subject (in `Tables`: barcode), range [m] and bearing [rad] from the forward axis.
        truth: (g, 4) time [s], x [m], y [m], heading [rad]; no rows where there is no file.
        dropped: What could not be used.
    """

    commands: Array
    measurements: Array
    truth: Array
    dropped: Dropped = field(default_factory=Dropped)

    def __post_init__(self) -> None:
        freeze(self)


@dataclass(frozen=True, eq=False)
class Tables:
    """The files of a run as they are: times on the logs' clock, barcodes instead of subjects.

    Attributes:
        name: The folder's name.
        barcodes: The subject that each barcode names.
        landmarks: (l, 3) subject, x [m], y [m], in the subjects' order.
        logs: Of each robot, by its number in the files.
    """

    name: str
    barcodes: Mapping[int, int]
    landmarks: Array
    logs: Mapping[int, RobotLog]

    def __post_init__(self) -> None:
        freeze(self)


@dataclass(frozen=True, eq=False)
class Run:
    """A run of the data set, put in order.

    Attributes:
        name: The folder's name.
        epoch: The first command or measurement of anybody, on the logs' clock; all times are counted from here [s].
        logs: Of each robot, by its number in the files; in order of time.
        landmarks: (l, 3) subject, x [m], y [m].
    """

    name: str
    epoch: float
    logs: Mapping[int, RobotLog]
    landmarks: Array

    @property
    def dropped(self) -> Dropped:
        """What of all robots' files could not be used."""
        return sum((log.dropped for log in self.logs.values()), Dropped())


def read_run(folder: Path) -> Run:
    """Return the run in a folder.

    A last line that is cut off is normal and left out; so is a barcode that names nobody. Both are counted.

    Raises:
        InvalidInput: A file is missing (but one of truth), or a line is damaged; the message has the file and the line.
    """
    return run_of(read_tables(folder))


def read_tables(folder: Path) -> Tables:
    """Return the files of a run as they are.

    Raises:
        InvalidInput: A file is missing (but one of truth), or a line is damaged; the message has the file and the line.
    """
    subjects, _ = _table(folder / "Barcodes.dat", 2, whole=True)
    landmarks, _ = _table(folder / "Landmark_Groundtruth.dat", 5, whole=True)
    robots = sorted(int(named[1]) for path in folder.glob("*") if (named := ODOMETRY.fullmatch(path.name)))
    if not robots:
        raise InvalidInput(f"logs of robots in {folder}", "no file Robot<k>_Odometry.dat")
    return Tables(
        name=folder.resolve().name,
        barcodes={int(barcode): int(subject) for subject, barcode in subjects},
        landmarks=landmarks[np.argsort(landmarks[:, 0])][:, :3],
        logs={robot: _log(folder, robot) for robot in robots},
    )


def run_of(tables: Tables) -> Run:
    """Return the run that the files tell of: in order of time, what cannot be used dropped and counted.

    Raises:
        InvalidInput: There is neither a command nor a measurement.
    """
    begun = [table[:, 0].min() for log in tables.logs.values() for table in (log.commands, log.measurements) if len(table)]
    if not begun:
        raise InvalidInput(f"commands or measurements in {tables.name}", "none")
    epoch = float(min(begun))
    logs = {robot: _usable(robot, log, tables.barcodes, epoch) for robot, log in tables.logs.items()}
    return Run(tables.name, epoch, logs, tables.landmarks)


def _log(folder: Path, robot: int) -> RobotLog:
    """Return a robot's files."""
    commands, cut = _table(folder / f"Robot{robot}_Odometry.dat", 3)
    measurements, cut_too = _table(folder / f"Robot{robot}_Measurement.dat", 4)
    where = folder / f"Robot{robot}_Groundtruth.dat"
    truth, cut_as_well = _table(where, 4) if where.exists() else (np.zeros((0, 4)), 0)
    return RobotLog(commands, measurements, truth, Dropped(cut_lines=cut + cut_too + cut_as_well))


def _usable(robot: int, log: RobotLog, barcodes: Mapping[int, int], epoch: float) -> RobotLog:
    subjects = np.array([barcodes.get(int(barcode), robot) for barcode in log.measurements[:, 1]], dtype=float)
    known, possible = subjects != robot, log.measurements[:, 2] >= 0
    named = np.column_stack([log.measurements[:, 0], subjects, log.measurements[:, 2:]])[known & possible]
    commands, measurements = _ordered(log.commands, epoch), _ordered(named, epoch)
    truth = _ordered(log.truth, epoch)
    dropped = log.dropped + Dropped(
        unknown_barcodes=int((~known).sum()),
        duplicates=len(log.commands) + len(named) - len(commands) - len(measurements),
        impossible=int((known & ~possible).sum()),
    )
    return RobotLog(commands, measurements, truth[np.unique(truth[:, 0], return_index=True)[1]], dropped)


def _ordered(table: Array, epoch: float) -> Array:
    """Return the rows in order of time, each once, with times since the epoch; rows of one time stay in their order."""
    once = np.sort(np.unique(table, axis=0, return_index=True)[1]) if len(table) else np.zeros(0, dtype=np.int64)
    rows = table[once]
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return np.column_stack([np.round(rows[:, 0] - epoch, DECIMALS), rows[:, 1:]])


def _table(path: Path, columns: int, whole: bool = False) -> tuple[Array, int]:
    """Return (k, columns) the numbers of a file, and whether (0 or 1) its last line was cut off and left out.

    Args:
        path: Of the file; what follows a # is a comment.
        columns: How many numbers a line has.
        whole: The file was not logged but written at once: a last line without an end is whole if it has all its numbers.
    """
    try:
        lines = [line.decode("ascii", errors="replace") for line in TextFile(path).lines()]
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
