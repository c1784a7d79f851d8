"""Other estimators, held against the regions of a run as it goes on."""

from __future__ import annotations

import csv
from pathlib import Path
from types import TracebackType

from experiments.following.metrics import Value
from experiments.keeping.running import Moment, Told
from experiments.watchdog.told import summary_of
from experiments.watchdog.watching import ALARM, Watching, write_episodes


class Watched(Told):
    """Keeps every alarm in `alarms.csv`, and every episode in `episodes.csv`.

    Attributes:
        watching: What judges.
    """

    def __init__(self, watching: Watching, folder: Path) -> None:
        self.watching, self._folder = watching, folder
        self._file = (folder / "alarms.csv").open("w", encoding="utf-8", newline="")
        self._alarms = csv.writer(self._file, lineterminator="\n")
        self._alarms.writerow(ALARM)

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        self._alarms.writerows(self.watching.judged(moment.step))

    def summary(self) -> dict[str, Value]:
        """Return the summary of `experiments.watch`, each name with `watch_` before it."""
        return {f"watch_{name}": value for name, value in summary_of(self.watching).items()}

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.watching.end()
        self._file.close()
        write_episodes(self._folder / "episodes.csv", self.watching.episodes)
