"""Pictures of what is answered, for a viewer that looks on and for a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from types import TracebackType
from uuid import uuid4

import numpy as np

from experiments.feeds.beside import Answered, Beside
from experiments.following.checks import Escapes
from experiments.keeping.recorded import Recorded
from experiments.keeping.running import Moment
from experiments.show.recording import Recording
from experiments.show.viewer import open_viewer
from filter import Array, Arrival, Belief, Event, Frame, Left, Measurement, Placed, Step, Team

SHARE = 0.2  # of the time pictures may take; the rest is for answers
MARKED = 0.5  # how long what is wrong stays to be seen [s]
NO_WALLS = np.zeros((0, 4))


def pictures(team: Team, path: Path | None, *, view: bool) -> Pictures:
    """Return what shows a team in a viewer, which is opened if need be, and records it to a path, or neither.

    Raises:
        NoViewer: No viewer can be opened.
        OSError: The file cannot be written.
    """
    viewer, own = open_viewer() if view else None, f"live_{uuid4()}"  # an open viewer may still show an earlier run
    recording = Recording(path, team, recording_id=own, walls=NO_WALLS, wall_height=0.0, inside=False, viewer=viewer, live=True)
    return Pictures(recording, team)


class Pictures(Beside):
    """Draws the newest answer with all that has come since the last picture, as often as pictures' share of the time allows.

    Truth is drawn at its own stamps.
    """

    def __init__(self, recording: Recording, team: Team) -> None:
        self._recording, self._recorded = recording, Recorded(recording, team)
        self._belief: Belief | None = None  # the newest one, until it is drawn
        self._next = 0.0
        self._come = list[Arrival]()
        self._events, self._before = dict[str, Event](), set[str]()
        self._outside = Escapes()
        self._words = list[str]()
        self._wrong = dict[str, tuple[float, Array]]()

    def keep(self, answered: Answered) -> None:
        """Take one answer in."""
        self._belief = answered.now.belief
        self._come += answered.records
        self._remember(self._belief.events)
        for _, escapes in answered.checked:
            positions, headings = (*self._outside.positions, *escapes.positions), (*self._outside.headings, *escapes.headings)
            self._outside = Escapes(tuple(sorted({*positions})), tuple(sorted({*headings})))
        if perf_counter() >= self._next:
            self._draw(self._belief)
        for frame, _ in answered.checked:
            self._recording.truth(frame)

    def mark(self, what: str, time: float, why: str, place: Array) -> None:
        """Have a place (2,) [m] marked for a moment that is proved to be wrong at a time [s]; why is told when that begins."""
        if what not in self._wrong:
            self._words.append(f"{what}: {why}")
        self._wrong[what] = time, place

    def _remember(self, events: Sequence[Event]) -> None:
        """Keep what has happened; a step that goes on says it again each time."""
        said = {str(event): event for event in events}
        self._events |= {words: event for words, event in said.items() if words not in self._before}
        self._before = set(said)

    def _draw(self, belief: Belief) -> None:
        began = perf_counter()
        measured = [each for each in self._come if isinstance(each, Measurement)]
        changes = [each for each in self._come if isinstance(each, Placed | Left)]
        told = replace(belief, events=tuple(self._events.values()))
        frame = Frame(belief.time, measurements=measured, changes=changes)
        self._recorded.keep(Moment(Step(frame, told, told, 0.0), self._outside, None))
        self._mark_all(belief.time)
        for kept in (self._come, self._events):
            kept.clear()
        self._belief, self._outside = None, Escapes()
        self._next = perf_counter() + (perf_counter() - began) / SHARE

    def _mark_all(self, now: float) -> None:
        if self._wrong:
            self._wrong = {what: (time, place) for what, (time, place) in self._wrong.items() if abs(now - time) < MARKED}
            self._recording.impossible([place for _, place in self._wrong.values()])
        for words in self._words:
            self._recording.event(words, "WARN")
        self._words.clear()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        try:
            if self._belief is not None:
                self._draw(self._belief)
        finally:
            self._recorded.__exit__(kind, error, trace)
