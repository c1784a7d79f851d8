"""A full disk, a closed pipe, a lost folder: one clear line, and a code that does not say that the truth was outside."""

import errno
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from experiments.moving_team import main as moving_team
from experiments.show import recording
from experiments.show.command import BAD_INPUT, CANNOT_WRITE, STOPPED, command
from experiments.show.output import write_summary, write_whole
from filter.errors import InvalidInput

ROOT = Path(__file__).parents[2]
FULL = Path("/dev/full")
TINY = ["--world", "kinematic", "--robots", "1", "--duration", "0.3"]
needs_full = pytest.mark.skipif(not FULL.exists(), reason="no device that is always full")


@dataclass(frozen=True)
class Options:
    """None."""


def ended(run):
    return command("none", Options, run, [], stopped="nothing is lost")


def raising(error):
    def run(_):
        raise error

    return run


def with_stdout(where, *arguments):
    """Run a program whose stdout is a file that is open already."""
    command = [sys.executable, *arguments]
    there = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        command, cwd=ROOT, env=there, stdout=where, stderr=subprocess.PIPE, text=True, check=False, timeout=300
    )


@pytest.fixture
def closed_pipe():
    """Where nobody reads any more, as after `| head -1`."""
    reader, writer = os.pipe()
    os.close(reader)
    yield writer
    os.close(writer)


def test_each_way_to_end_has_a_code_of_its_own(capsys):
    assert ended(lambda _: 0) == 0
    assert ended(lambda _: 1) == 1
    assert ended(raising(InvalidInput("a", "b"))) == BAD_INPUT
    assert ended(raising(OSError(errno.ENOSPC, "No space left on device", "somewhere/log.jsonl"))) == CANNOT_WRITE
    assert ended(raising(KeyboardInterrupt())) == STOPPED
    assert len({0, 1, BAD_INPUT, CANNOT_WRITE, STOPPED}) == 5
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert lines[1].startswith("error: somewhere/log.jsonl: No space left on device")


@needs_full
@pytest.mark.parametrize("name", ["log.jsonl", ".summary.json.tmp", "trajectories/r0_filter.tum", "moving_team.rrd"])
def test_a_disk_that_is_full_ends_a_run_with_one_line_and_no_summary(tmp_path, capfd, monkeypatch, name):
    monkeypatch.setattr("experiments.show.output.FRAMES_KEPT", 2)
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).symlink_to(FULL)
    monkeypatch.setattr(Path, "unlink", unlink_but(FULL))
    assert moving_team([*TINY, "--out", str(tmp_path)]) == CANNOT_WRITE
    assert not (tmp_path / "summary.json").exists()
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("error")]
    assert "space" in line


def unlink_but(kept):
    """Return how files are removed, but for links to one: runs remove what earlier runs have left."""
    before = Path.unlink

    def unlink(path, missing_ok=False):
        if not (path.is_symlink() and path.readlink() == kept):
            before(path, missing_ok)

    return unlink


def test_a_disk_without_room_for_the_recording_ends_the_run(tmp_path, capsys, monkeypatch):
    """Rerun itself would wait for room for ever."""
    monkeypatch.setattr(recording, "ROOM", 1 << 62)
    assert moving_team([*TINY, "--out", str(tmp_path)]) == CANNOT_WRITE
    assert "moving_team.rrd: No space left on device" in capsys.readouterr().err
    assert not (tmp_path / "summary.json").exists()


def test_a_disk_that_fills_up_during_a_run_ends_it(tmp_path, capsys, monkeypatch):
    usage, calls = shutil.disk_usage(tmp_path), []

    def filling(path):
        calls.append(path)
        return usage._replace(free=usage.free if len(calls) < 3 else 0)

    monkeypatch.setattr(recording.shutil, "disk_usage", filling)
    monkeypatch.setattr(recording, "SEND_EVERY", 0.1)
    assert moving_team([*TINY, "--out", str(tmp_path)]) == CANNOT_WRITE
    assert "No space left on device" in capsys.readouterr().err
    assert len((tmp_path / "log.jsonl").read_text().splitlines()) > 2  # what came before is there


def test_a_folder_that_cannot_be_made_is_bad_input(capsys):
    assert moving_team([*TINY, "--out", "/proc/nope"]) == BAD_INPUT
    assert "/proc/nope" in capsys.readouterr().err


def test_a_summary_is_there_as_a_whole_or_not_at_all(tmp_path):
    write_summary(tmp_path, {"escapes": 0})
    assert json.loads((tmp_path / "summary.json").read_text()) == {"escapes": 0}
    with pytest.raises(ValueError, match="JSON"):
        write_summary(tmp_path, {"escapes": float("nan")})
    assert json.loads((tmp_path / "summary.json").read_text()) == {"escapes": 0}
    assert [path.name for path in tmp_path.iterdir()] == ["summary.json"]


@needs_full
def test_what_cannot_be_written_whole_leaves_the_old_file_and_no_other(tmp_path, monkeypatch):
    write_whole(tmp_path / "file", "old")
    with FULL.open("wb", buffering=0) as full:
        monkeypatch.setattr(os, "fsync", lambda _: full.write(b"x"))
        with pytest.raises(OSError, match="space"):
            write_whole(tmp_path / "file", "new")
    assert (tmp_path / "file").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


TABLE = """
import sys
sys.path.insert(0, ".")
from dataclasses import dataclass
from experiments.show.command import command
from experiments.show.terminal import print_table

@dataclass(frozen=True)
class Options:
    "None."

def run(_):
    print_table("a table", {"escapes": 0})
    return 0
sys.exit(command("none", Options, run, sys.argv[1:], stopped=""))
"""


def test_a_table_that_nobody_reads_is_said_in_one_line(closed_pipe):
    run = with_stdout(closed_pipe, "-c", TABLE)
    assert run.returncode == CANNOT_WRITE
    assert re.fullmatch(r"error: Broken pipe;.*\n", run.stderr)


@needs_full
def test_a_table_that_does_not_fit_on_the_disk_is_said_in_one_line():
    with FULL.open("w") as full:
        run = with_stdout(full, "-c", TABLE)
    assert run.returncode == CANNOT_WRITE
    assert re.fullmatch(r"error: No space left on device;.*\n", run.stderr)


def test_help_that_nobody_reads_is_no_lost_truth_either(closed_pipe):
    assert with_stdout(closed_pipe, "-c", TABLE, "--help").returncode == CANNOT_WRITE


def test_with_nobody_at_stderr_the_code_still_tells(closed_pipe):
    command = [sys.executable, "-c", TABLE]
    run = subprocess.run(command, cwd=ROOT, stdout=closed_pipe, stderr=closed_pipe, check=False, timeout=300)
    assert run.returncode == CANNOT_WRITE


def test_a_verdict_that_cannot_be_told_is_none(tmp_path, closed_pipe):
    (tmp_path / "log.jsonl").write_text("")
    (tmp_path / "certificates.jsonl.gz").write_bytes(b"")
    assert with_stdout(subprocess.DEVNULL, "-m", "experiments.prove", str(tmp_path)).returncode == 1
    untold = with_stdout(closed_pipe, "-m", "experiments.prove", str(tmp_path))
    assert untold.returncode == CANNOT_WRITE
    assert untold.stderr.splitlines()[-1] == "error: the verdict cannot be written: Broken pipe"


def test_everybody_writes_by_the_console_that_survives():
    users = [path.name for path in (ROOT / "experiments").rglob("*.py") if "rich.console" in path.read_text()]
    assert users == ["terminal.py"]
