"""However a sweep is ended, it leaves no process behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATIENCE = 30.0  # [s]

SWEEP = """
import sys, time
from concurrent.futures import wait
from pathlib import Path

from experiments.sweep.executors import executor

def work(folder):
    import os
    Path(folder, str(os.getpid())).touch()
    time.sleep(600)

if __name__ == "__main__":
    with executor(2) as pool:
        wait([pool.submit(work, sys.argv[1]) for _ in range(4)])
"""
OWN_PROCESS = """
import os, sys, time
from pathlib import Path

from experiments.sweep.own_process import in_own_process

def work(folder):
    for _ in range(2):
        Path(folder, str(os.getpid())).touch()
        yield 1
        time.sleep(600)

if __name__ == "__main__":
    list(in_own_process(work, sys.argv[1]))
"""


def is_there(process):
    """Return whether a process works, by its number; one that has ended and that nobody asks about does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().split(") ")[-1][0] != "Z"
    except FileNotFoundError:
        return False


def until(holds):
    end = time.monotonic() + PATIENCE
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    return holds()


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes cannot be looked at here")
@pytest.mark.parametrize(("program", "workers"), [(SWEEP, 2), (OWN_PROCESS, 1)], ids=["sweep", "own process"])
@pytest.mark.parametrize("how", ["SIGTERM", "SIGKILL", "SIGINT"])
def test_a_sweep_that_is_ended_leaves_no_worker_behind(tmp_path, program, workers, how):
    (tmp_path / "numbers").mkdir()
    (tmp_path / "program.py").write_text(program)
    command = [sys.executable, str(tmp_path / "program.py"), str(tmp_path / "numbers")]
    there = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, env=there, stderr=subprocess.PIPE, text=True, start_new_session=True) as sweep:
        assert until(lambda: len(list((tmp_path / "numbers").iterdir())) == workers)
        numbers = [int(path.name) for path in (tmp_path / "numbers").iterdir()]
        assert all(map(is_there, numbers))
        if how == "SIGINT":  # by a terminal: to all of them
            os.killpg(sweep.pid, signal.SIGINT)
        else:
            sweep.send_signal(getattr(signal, how))
        sweep.wait(PATIENCE)
        assert until(lambda: not any(map(is_there, numbers)))
        said = sweep.stderr.read()
    assert said.count("Traceback") <= (how == "SIGINT")  # of the sweep itself
