"""A run's regions, kept in the formats that were asked for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from experiments.keeping.running import Keeper, Moment
from experiments.regions.rows import rows_of
from experiments.regions.writers import Format, regions_writer


class RegionFiles(Keeper):
    """Keeps the regions of robots with these names, in files of one folder."""

    def __init__(self, folder: Path, names: Sequence[str], formats: Iterable[Format]) -> None:
        """Open the files; raises `InvalidInput` if a package is missing, `OSError` if one cannot be written."""
        self._names = names
        self._writers = [regions_writer(form, folder) for form in dict.fromkeys(formats)]

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        rows = rows_of(self._names, moment.step.frame.time, moment.step.belief, moment.beside)
        for writer in self._writers:
            writer.write(rows)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        with ExitStack() as closing:  # all of them, if one cannot be closed, too
            for writer in self._writers:
                closing.callback(writer.close)
