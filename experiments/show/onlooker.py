"""A viewer that looks on: it may be slow, be stopped, or be closed at any moment, and the run goes on all the same."""

from __future__ import annotations

import atexit
from collections.abc import Callable
from queue import SimpleQueue
from threading import Event, Thread
from time import monotonic, sleep

import rerun as rr

from experiments.show.terminal import tell

MOST = 50  # things that wait for a viewer
PATIENCE = 10.0  # that a viewer may take to receive what it was sent [s]
GLANCE = 0.01  # from one look at whether there is room to the next [s]

Shown = Callable[[rr.RecordingStream], None]


class Onlooker:
    """Sends things to a viewer on a thread of its own, as Rerun waits for a viewer that does not read.

    Attributes:
        missed: How many things a slow viewer was not shown.
        gone: Whether the viewer is there no more; that is told once.
    """

    def __init__(self, connected: Callable[[], rr.RecordingStream], patience: float = PATIENCE) -> None:
        """Begin to send on what `connected` returns, and wait so long for a viewer that is behind before it misses any [s]."""
        self.missed, self.gone, self._patience = 0, False, patience
        self._waiting: SimpleQueue[Shown | None] = SimpleQueue()
        self._connected = connected
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def show(self, what: Shown, *, for_sure: bool = False) -> None:
        """Have something sent; unless it is for sure, a viewer that is too far behind does without."""
        if for_sure or self._has_room():
            self._waiting.put(what)
        else:
            self.missed += 1

    def close(self) -> None:
        """Wait for what is left to be received, but not for long."""
        self._waiting.put(None)
        self._thread.join(0 if self.gone else PATIENCE)
        if self._thread.is_alive():
            # Rerun waits at the end of the process for all that was not received, for ever.
            atexit.unregister(rr.rerun_shutdown)

    def _has_room(self) -> bool:
        end = monotonic() + self._patience
        while self._waiting.qsize() >= MOST and not self.gone and monotonic() < end:
            sleep(GLANCE)
        return self._waiting.qsize() < MOST and not self.gone

    def _run(self) -> None:
        try:
            stream = self._connected()
            while (what := self._waiting.get()) is not None:
                what(stream)
                if self._waiting.empty():
                    stream.flush(timeout_sec=PATIENCE)
        except RuntimeError:
            tell("the viewer does not receive any more: the run goes on without it")
            self.gone = True
            Event().wait()  # to let go of the stream would be to wait for the viewer
        stream.disconnect()
