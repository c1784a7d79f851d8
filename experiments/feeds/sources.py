"""Where lines come from: standard input, or connections that are waited for, one at a time."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from contextlib import suppress
from importlib.util import find_spec
from io import BufferedReader
from itertools import count
from threading import Lock
from typing import Any, cast
from urllib.parse import urlsplit

from experiments.feeds.intake import Intake, Source
from experiments.feeds.lines import MOST
from filter import InvalidInput

BLOCK = 1 << 16  # bytes that are read at a time
LOOPBACK = "127.0.0.1"  # where nobody but this machine can send to
EXPECTED = "- for standard input, tcp://HOST:PORT or ws://HOST:PORT"


def source_of(place: str, connections: int | None) -> Source:
    """Return what is to be listened to; connections are waited for from now on.

    Args:
        place: -, tcp://HOST:PORT or ws://HOST:PORT; without a host it is this machine alone, and port 0 is any free one.
        connections: How many are taken, one after the other; None for no end.

    Raises:
        InvalidInput: It is nothing of that kind, one cannot listen there, or the package for ws is not installed.
    """
    if place == "-":
        return StandardInput()
    scheme, host, port = _address(place)
    try:
        return (Tcp if scheme == "tcp" else WebSocket)(host, port, connections)
    except OSError as error:
        raise InvalidInput("a host and a port to listen on", f"{place}: {error.strerror or error}") from None


def _address(place: str) -> tuple[str, str, int]:
    parts = urlsplit(place)
    with suppress(ValueError):
        if parts.scheme in ("tcp", "ws") and parts.port is not None and parts.path in ("", "/"):
            return parts.scheme, parts.hostname or LOOPBACK, parts.port
    raise InvalidInput(EXPECTED, place)


def _turns(connections: int | None) -> Iterator[int]:
    return iter(count() if connections is None else range(connections))


class StandardInput:
    """Standard input, to its end."""

    name = "standard input"

    def run(self, intake: Intake) -> None:
        """Hand over all that comes."""
        file = cast(BufferedReader, sys.stdin.buffer).raw  # without the lock that would be held when the run ends otherwise
        while block := file.read(BLOCK):
            intake.heard(block)
        intake.over()


class Tcp:
    """Connections to a port; the next one is taken when the one before has closed."""

    def __init__(self, host: str, port: int, connections: int | None) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._server, self._connections = socket.create_server((host, port), family=family, backlog=1), connections
        self.name = "{}:{}".format(*self._server.getsockname()[:2])

    def run(self, intake: Intake) -> None:
        """Take one connection after the other."""
        with self._server:
            intake.say(f"listening on tcp, {self.name}")
            for _ in _turns(self._connections):
                connection, (host, port, *_) = self._server.accept()
                with connection:
                    intake.say(f"{host}:{port} is connected")
                    intake.say(f"{host}:{port} {_heard(connection, intake)}")


def _heard(connection: socket.socket, intake: Intake) -> str:
    """Hand over all that comes; return how it ended, in words."""
    ended = "has closed"
    try:
        while block := connection.recv(BLOCK):
            intake.heard(block)
    except OSError as error:
        ended = f"is lost: {error.strerror or error}"
    intake.over()
    return ended


class WebSocket:
    """Connections by WebSocket: a message is a line, or several; the next one is heard when the one before has closed."""

    def __init__(self, host: str, port: int, connections: int | None) -> None:
        if find_spec("websockets") is None:
            raise InvalidInput("the package websockets for ws:// (pip install websockets; Corral's extra live has it)", "none")
        from websockets.sync.server import serve  # noqa: PLC0415 - few need it

        self._left, self._turn, self._intake = connections, Lock(), Intake()
        self._server = serve(self._connected, host, port, max_size=MOST, compression=None)
        self.name = "{}:{}".format(*self._server.socket.getsockname()[:2])

    def run(self, intake: Intake) -> None:
        """Take one connection after the other."""
        self._intake = intake
        intake.say(f"listening on ws, {self.name}")
        if self._left != 0:
            self._server.serve_forever()

    def _connected(self, connection: Any) -> None:
        """Hand over what a connection sends, when it is its turn."""
        with self._turn:
            if self._left == 0:
                return
            host, port, *_ = connection.remote_address
            self._intake.say(f"{host}:{port} is connected")
            self._intake.say(f"{host}:{port} {self._heard(connection)}")
            self._left = None if self._left is None else self._left - 1
            if self._left == 0:
                self._server.shutdown()

    def _heard(self, connection: Any) -> str:
        """Hand over all messages; return how it ended, in words."""
        from websockets.exceptions import ConnectionClosed  # noqa: PLC0415

        try:
            for message in connection:
                self._intake.heard(message if isinstance(message, bytes) else message.encode())
                self._intake.over()
        except ConnectionClosed as error:  # as one does whose message is too long
            return f"is lost: {error}"
        return "has closed"
