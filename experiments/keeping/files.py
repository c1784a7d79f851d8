"""Poses of a run as TUM files, and the certificates of its regions."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType

from experiments.following.located import directions, points
from experiments.keeping.running import Keeper, Moment
from experiments.logs import Certificates
from experiments.show.output import Trajectories
from filter import InvalidInput, Team


def check_provable(team: Team) -> None:
    """Raise `InvalidInput` for a sensor whose clock may be off, of which `experiments.prove` does not know."""
    off = next((sensor for sensor in team.sensors if sensor.time_bound), None)
    if off is not None:
        raise InvalidInput("sensors without a time_bound for --certificates, as yet", off.name)


class Poses(Keeper):
    """Keeps the trajectories: the filter's own, the truth's where it is known, and the Kalman filter's if one is beside."""

    def __init__(self, folder: Path, team: Team) -> None:
        self._files = Trajectories(folder, team)

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        frame, belief, beside = moment.step.frame, moment.step.belief, moment.beside
        self._files.write(frame, belief)
        if beside is not None:
            self._files.estimate("ekf", frame.time, points(beside), directions(beside))

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._files.close()


class Proofs(Keeper):
    """Keeps the certificates, and the regions that they prove."""

    def __init__(self, folder: Path, team: Team) -> None:
        self._files = Certificates(folder, team)

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        self._files.write(moment.step)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._files.close()
