"""A live viewer on this machine's screen: finds one that is open, or opens one."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, sleep

from filter import CorralError

HOST, PORT = "127.0.0.1", 9876
PATIENCE = 20.0  # [s] that a viewer may take to open
SETTLING = 1.0  # [s]; a viewer listens first and looks for a screen afterwards


class NoViewer(CorralError):
    """A live viewer could not be opened; everything else works without."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"no live viewer ({reason}): is there a screen? A run without --view records just the same")
        self.reason = reason


def open_viewer() -> str:
    """Return the address of a live viewer that stays open after the run; only this machine can reach it.

    Raises:
        NoViewer: There is none, and none can be opened.
    """
    if not _listens():
        _start()
    return f"rerun+http://{HOST}:{PORT}/proxy"


def _start() -> None:
    command = [_program(), "--bind", HOST, "--port", str(PORT), "--hide-welcome-screen"]
    viewer = subprocess.Popen(  # noqa: S603 the command is ours
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "RERUN_APP_ONLY": "true"},
        start_new_session=True,  # so that it outlives the run, and Ctrl-C
    )
    end, listens_since = monotonic() + PATIENCE, None
    while listens_since is None or monotonic() - listens_since < SETTLING:
        if viewer.poll() is not None:
            raise NoViewer(f"it ended with {viewer.returncode}")
        if monotonic() > end:
            viewer.terminate()
            raise NoViewer(f"it did not open within {PATIENCE:g} s")
        if listens_since is None and _listens():
            listens_since = monotonic()
        sleep(0.05)


def _program() -> str:
    """Return the path of the viewer itself: ending its Python wrapper would leave it running."""
    package = find_spec("rerun_cli")
    program = shutil.which("rerun", path=Path(package.origin).parent) if package and package.origin else None
    if program is None:
        raise NoViewer("none is installed")
    return program


def _listens() -> bool:
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex((HOST, PORT)) == 0
