"""Other estimators, held against the regions of a run as it goes on."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType

from experiments.following.metrics import Value
from experiments.keeping.running import Moment, Told
from experiments.watchdog.told import summary_of
from experiments.watchdog.watching import ALARM, Judged, Row, Watching, write_episodes

POSES = "r*.tum"  # of the folder that is watched
BACK = 1.0  # how far an alarm is traced back [s]
TOLERANCE = 1e-6  # of the stamps of watched poses [s]
ALARMS, EPISODES = "alarms.csv", "episodes.csv"


class AlarmFiles:
    """Keeps every alarm in `alarms.csv`, and every episode in `episodes.csv`."""

    def __init__(self, folder: Path) -> None:
        self._episodes = folder / EPISODES
        self._file = (folder / ALARMS).open("w", encoding="utf-8", newline="")
        self._alarms = csv.writer(self._file, lineterminator="\n")
        self._alarms.writerow(ALARM)

    def write(self, rows: Iterable[Row]) -> None:
        """Write alarms, each a row of `ALARM`, and see them off."""
        for row in rows:
            self._alarms.writerow(row)
            self._file.flush()

    def end(self, judged: Judged) -> None:
        """Write the episodes: there is no further pose to judge."""
        judged.end()
        self._file.close()
        write_episodes(self._episodes, judged.episodes)


def watch_summary(judged: Judged) -> dict[str, Value]:
    """Return the summary of `experiments.watch`, each name with `watch_` before it."""
    return {f"watch_{name}": value for name, value in summary_of(judged).items()}


class Watched(Told):
    """Keeps the alarms and the episodes of a run.

    Attributes:
        watching: What judges.
    """

    def __init__(self, watching: Watching, folder: Path) -> None:
        self.watching, self._files = watching, AlarmFiles(folder)

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        self._files.write(self.watching.judged(moment.step))

    def summary(self) -> dict[str, Value]:
        """Return what was watched, and how much of it is proved wrong."""
        return watch_summary(self.watching)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._files.end(self.watching)
