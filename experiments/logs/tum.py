"""Trajectories in TUM's format: a line a pose, t x y z qx qy qz qw; empty lines and lines with # say nothing."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.logs.checks import read_only
from experiments.logs.text import TextFile
from filter import Array, InvalidInput

COLUMNS = 8
ROBOT = re.compile(r"r(\d+)(?!\d)")  # what a file's name begins with


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Where one robot was at some times.

    Attributes:
        times: (k,) increasing [s].
        positions: (k, 2) [m].
    """

    times: Array
    positions: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", read_only(self.times))
        object.__setattr__(self, "positions", read_only(self.positions))


def read_trajectory(path: Path) -> Trajectory:
    """Return a trajectory.

    Raises:
        InvalidInput: The file cannot be read, has no pose, or a line is none; or time does not advance.
    """
    try:
        lines = [line.decode().strip() for line in TextFile(path).lines()]
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput("a readable TUM file", f"{path}: {error}") from None
    poses = []
    for number, line in enumerate(lines, 1):
        if line and not line.startswith("#"):
            poses.append(_pose(path, number, line))
            if len(poses) > 1 and poses[-1][0] <= poses[-2][0]:
                raise InvalidInput(f"{path}, line {number}: a time after {poses[-2][0]!r} s", f"{poses[-1][0]!r} s")
    if not poses:
        raise InvalidInput(f"{path}: at least one pose", "none")
    table = np.array(poses)
    return Trajectory(table[:, 0].copy(), table[:, 1:3].copy())


def _pose(path: Path, number: int, line: str) -> list[float]:
    try:
        pose = [float(word) for word in line.split()]
    except ValueError:
        pose = []
    if len(pose) != COLUMNS or not np.isfinite(pose).all():
        raise InvalidInput(f"{path}, line {number}: {COLUMNS} finite numbers, t x y z qx qy qz qw", repr(line))
    return pose


def find_trajectories(place: Path, pattern: str, robots: int) -> dict[str, dict[int, Path]]:
    """Return each estimator's files by robot: of one file, or of those in a folder.

    r3.tum is robot 3's by the estimator without a name, r3_slam.tum robot 3's by slam.

    Raises:
        InvalidInput: There is none, a name tells no robot of the team, or a robot has two by one estimator.
    """
    files = sorted(place.glob(pattern)) if place.is_dir() else [place]
    found: dict[str, dict[int, Path]] = {}
    for file in files:
        named = ROBOT.match(file.name)
        if named is None or int(named[1]) >= robots:
            raise InvalidInput(f"files named for a robot, r0 to r{robots - 1}, as in r0.tum or r0_slam.tum", str(file))
        estimator = Path(file.name.removesuffix(".gz")).stem[named.end() :].lstrip("_-")
        robot, of_one = int(named[1]), found.setdefault(estimator, {})
        if robot in of_one:
            raise InvalidInput("one trajectory a robot and estimator", f"{of_one[robot].name} and {file.name}")
        of_one[robot] = file
    if not found:
        raise InvalidInput(f"trajectories {pattern} in {place}", "none")
    return found


def tum_line(time: float, position: Array, heading: float) -> str:
    """Return a pose in the plane as a line of a TUM file: t x y z qx qy qz qw."""
    x, y = position.tolist()
    turn = (0.0, 0.0, float(np.sin(heading / 2)), float(np.cos(heading / 2)))
    return " ".join(repr(float(value)) for value in (time, x, y, 0.0, *turn)) + "\n"
