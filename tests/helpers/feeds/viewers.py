"""Viewers for tests: Rerun's own program without a screen, which can be stopped and killed."""

import signal
import socket
import subprocess
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep

import rerun_cli


class Viewer:
    """Receives what is sent to its address."""

    def __init__(self, port, process):
        self.port, self.address, self._process = port, f"rerun+http://127.0.0.1:{port}/proxy", process

    def freeze(self):
        """Let it receive nothing any more, though it is there."""
        self._process.send_signal(signal.SIGSTOP)

    def kill(self):
        """Let it be there no more."""
        self._process.kill()
        self._process.wait()


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@contextmanager
def viewer():
    """Run one."""
    port = free_port()
    command = [Path(rerun_cli.__file__).with_name("rerun"), "--serve-grpc", "--bind", "127.0.0.1", "--port", str(port)]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        end = monotonic() + 30
        while monotonic() < end:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    break
            sleep(0.05)
        yield Viewer(port, process)
    finally:
        process.kill()
        process.wait()
