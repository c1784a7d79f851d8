"""The files of a run: its folder, its summary, its trajectories."""

from __future__ import annotations

import json
import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

import numpy as np

from experiments.following.located import Located, directions, points
from experiments.following.metrics import Value
from experiments.logs import tum_line
from filter import Array, Frame, GaussianBelief, InvalidInput, Team

KINDS = ("filter", "truth", "ekf")  # of trajectories
FRAMES_KEPT = 100  # so many are written at a time: a file for each of many robots cannot be open all along


def output_folder(path: Path) -> Path:
    """Return a folder to write to, made if need be.

    Raises:
        InvalidInput: It cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / "summary.json"
        probe.unlink(missing_ok=True)  # one of an earlier run must not outlive a run that fails
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InvalidInput("an output folder that can be written to", f"{path}: {error.strerror}") from None
    return path


def write_summary(folder: Path, summary: Mapping[str, Value | Sequence[Value] | Mapping[str, Value]]) -> None:
    """Write `summary.json`, flat but for lists, and for figures by the names of what there are several of."""
    write_whole(folder / "summary.json", json.dumps(summary, indent=2, allow_nan=False) + "\n")


def write_whole(path: Path, text: str) -> None:
    """Write a file under a temporary name and move it into place: what has its name is whole, whenever the machine stops."""
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        with temporary.open("w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


class Trajectories:
    """Writes `trajectories/r0_filter.tum` (and `r0_truth.tum` where it is known) of every robot, as a run goes on.

    TUM's format, a line a frame: t x y z qx qy qz qw, one blank between. The filter's position is the centroid of the outer
    polygon, its heading the centre of the interval; a Kalman filter's are its means. Floats are written so that they come back
    exactly.

    Use as a context manager, or call `close`.
    """

    def __init__(self, folder: Path, team: Team) -> None:
        self._team = team
        self._folder = folder / "trajectories"
        self._folder.mkdir(exist_ok=True)
        for old in [*self._folder.glob("r*_*.tum"), *(path for kind in KINDS for path in self._folder.glob(f"*_{kind}.tum"))]:
            old.unlink(missing_ok=True)
        self._lines: dict[str, list[str]] = defaultdict(list)
        self._frames = 0

    def write(self, frame: Frame, belief: Located | GaussianBelief) -> None:
        """Append one frame."""
        self.estimate("filter", frame.time, points(belief), directions(belief))
        if frame.truth is not None:
            self.estimate("truth", frame.time, frame.truth.positions, frame.truth.headings)
        self._frames += 1
        if self._frames % FRAMES_KEPT == 0:
            self.close()

    def estimate(self, kind: str, time: float, positions: Array, headings: Array) -> None:
        """Append poses (n, 2) [m] and (n,) [rad] of one time to `r0_<kind>.tum` and so on; those with NaN are left out."""
        for robot, (position, heading) in enumerate(zip(positions, headings, strict=True)):
            if np.isfinite(position).all() and np.isfinite(heading):
                line = tum_line(time, position, float(heading))
                self._lines[f"{self._team.name(robot)}_{kind}.tum"].append(line)

    def close(self) -> None:
        """Write what is left."""
        for name, lines in self._lines.items():
            with (self._folder / name).open("a", encoding="utf-8", newline="\n") as file:
                file.writelines(lines)
        self._lines.clear()

    def __enter__(self) -> Trajectories:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
