"""Files as people have them: what can be read is read, and of what cannot the line is told."""

import gzip
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from experiments.logs import Header, InitialSet, LogReader, LogWriter, first_belief, read_trajectory
from experiments.logs.log import InvalidLog
from experiments.logs.writing import header_object
from experiments.proof.given.log import Log
from experiments.real_robots.data import read_tables
from filter import Compass, ExtendedKalmanFilter, Frame, InvalidInput, Range, RobustFilter, SetMembershipFilter, Team

ROOT = Path(__file__).parents[2]
TEAM = Team(1, [[3.0, 0.0]], 0.5, 1.5, [[-9, -9], [9, 9]])
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def frame(time):
    return Frame(time, None, (Compass(time, 0, 0.1, 0.05), Range(time, 0, 1, 3.0, 0.1, 0.0)))


@pytest.fixture
def text(tmp_path):
    """The bytes of a log of three frames."""
    path = tmp_path / "plain.jsonl"
    with LogWriter(path, Header(TEAM, 0.0, None), [InitialSet(SQUARE)]) as log:
        for time in (0.0, 0.1, 0.2):
            log.write(frame(time))
    return path.read_bytes()


SPELLINGS = {
    "a byte order mark": lambda text: b"\xef\xbb\xbf" + text,
    "Windows line ends": lambda text: text.replace(b"\n", b"\r\n"),
    "blank lines anywhere": lambda text: b"\n  \n" + text.replace(b"\n", b"\n\n \t\r\n"),
    "no line end at the end": lambda text: text.rstrip(b"\n"),
    "gzip, whatever its name": gzip.compress,
    "gzip of all that": lambda text: gzip.compress(b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n") + b"\r\n"),
    "gzip in two members": lambda text: gzip.compress(text[:300]) + gzip.compress(text[300:]),
}


def told(reader):
    frames = [(each.time, *(record.robot.tolist() for record in each.measurements)) for each in reader.frames()]
    return header_object(reader.header), reader.initial[0].vertices, frames


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_a_log_is_read_however_it_is_spelled(tmp_path, text, spelling):
    path = tmp_path / "log.jsonl"
    path.write_bytes(SPELLINGS[spelling](text))
    plain, reader = (told(LogReader(each)) for each in (tmp_path / "plain.jsonl", path))
    assert reader[0] == plain[0]
    assert np.array_equal(reader[1], plain[1])
    assert reader[2] == plain[2]
    assert len(reader[2]) == 3


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_what_comes_through_a_pipe_can_be_read_again_and_again(tmp_path, text, pack):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    thread = threading.Thread(target=lambda: pipe.write_bytes(pack(text)), daemon=True)
    thread.start()
    reader = LogReader(pipe)
    thread.join()
    assert len(list(reader.frames())) == len(list(reader.frames())) == 3


def test_a_command_replays_a_pipe(tmp_path, text):
    command = [sys.executable, "-m", "experiments.moving_team", "--replay", "/dev/stdin", "--out", str(tmp_path / "out")]
    ran = subprocess.run(command, input=gzip.compress(text), cwd=ROOT, capture_output=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "out" / "log.jsonl").read_bytes() == text


def cut_gzip(text):
    return gzip.compress(text)[:-20]


DAMAGED = {
    "a last line that is cut off": (lambda text: text[:-5], r"line 11: .*whole line; came a truncated one"),
    "cut off within a line of the middle": (lambda text: text[:-5] + b"\n", r"line 11: .*a JSON object"),
    "NaN": (lambda text: text.replace(b"[3.0]", b"[NaN]", 1), r"line 4: .*leave out what was not measured\); came NaN"),
    "Infinity": (lambda text: text.replace(b"[3.0]", b"[-Infinity]", 1), r"line 4: .*finite numbers.*; came -Infinity"),
    "a number that is none": (lambda text: text.replace(b"[3.0]", b"[1e999]", 1), r"line 4: .*finite numbers; came inf"),
    "gzip that is cut off": (cut_gzip, "compressed by gzip, but cut off or damaged"),
    "gzip with wrong bytes": (lambda text: gzip.compress(text)[:40] + b"\0" * 40, "compressed by gzip, but cut off or damaged"),
    "UTF-16": (lambda text: text.decode().encode("utf-16"), "UTF-16, where UTF-8 is read: save it as UTF-8"),
    "another encoding": (lambda text: text.replace(b"compass", b"comp\xe4ss", 1), "line 3: .*a JSON object"),
    "blank lines alone": (lambda text: b"\n \r\n\n", "a log with a header; came an empty file"),
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_log_that_is_damaged_is_refused_with_its_line_or_what_to_do(tmp_path, text, damage):
    path = tmp_path / "log.jsonl"
    change, match = DAMAGED[damage]
    path.write_bytes(change(text))
    with pytest.raises(InvalidLog, match=match):
        list(LogReader(path).frames())


def test_blank_lines_count_in_the_number_of_a_line(tmp_path, text):
    path = tmp_path / "log.jsonl"
    path.write_bytes(b"\n\r\n" + text.replace(b"[3.0]", b"[null]", 1))
    with pytest.raises(InvalidLog, match="line 6: "):
        list(LogReader(path).frames())


@pytest.mark.parametrize("kind", [SetMembershipFilter, RobustFilter, ExtendedKalmanFilter])
def test_a_start_that_is_unknown_is_the_arena(tmp_path, kind):
    path = tmp_path / "unknown.jsonl"
    with LogWriter(path, Header(TEAM, 0.0, None), [InitialSet()]) as log:
        log.write(frame(0.0))
    assert json.loads(path.read_text().splitlines()[1])["vertices"] is None
    reader = LogReader(path)
    assert reader.initial[0].polygon() is None
    belief = first_belief(kind(TEAM), reader.header, reader.initial)
    if kind is ExtendedKalmanFilter:
        assert belief.position_covariances[0] == pytest.approx(np.eye(2) * 18**2 / 12)
    else:
        assert belief.regions[0].outer.area == pytest.approx(18**2)


def test_an_unknown_start_in_an_open_arena_is_refused(tmp_path):
    team = Team(1, [[3.0, 0.0]])
    with pytest.raises(InvalidInput, match="a closed arena"):
        first_belief(SetMembershipFilter(team), Header(team, 0.0, None), [InitialSet()])


def test_the_checker_of_proofs_takes_an_unknown_start_for_the_arena(tmp_path):
    with LogWriter(tmp_path / "log.jsonl", Header(TEAM, 0.0, None), [InitialSet()]) as log:
        log.write(frame(0.0))
    corners = Log(tmp_path).starts[0].place.corners
    assert {tuple(map(float, corner)) for corner in corners} == {(-9, -9), (-9, 9), (9, -9), (9, 9)}


POSES = b"# t x y z qx qy qz qw\n0.0 1 2 0 0 0 0 1\n0.1 1 3 0 0 0 0 1\n"


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_a_trajectory_is_read_however_it_is_spelled(tmp_path, spelling):
    path = tmp_path / "r0.tum"
    path.write_bytes(SPELLINGS[spelling](POSES))
    assert read_trajectory(path).positions.tolist() == [[1.0, 2.0], [1.0, 3.0]]


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (POSES[:-4], "line 3: 8 finite numbers"),
        (POSES.replace(b" 3 ", b" nan "), "line 3: 8 finite numbers"),
        (gzip.compress(POSES)[:-12], "compressed by gzip, but cut off or damaged"),
        (POSES.decode().encode("utf-16"), "save it as UTF-8"),
    ],
    ids=["cut off", "nan", "gzip", "UTF-16"],
)
def test_a_trajectory_that_is_damaged_is_refused_with_its_line_or_what_to_do(tmp_path, text, match):
    path = tmp_path / "r0.tum"
    path.write_bytes(text)
    with pytest.raises(InvalidInput, match=match):
        read_trajectory(path)


@pytest.mark.parametrize("spelling", [name for name in SPELLINGS if name != "no line end at the end"])
def test_the_files_of_a_data_set_are_read_however_they_are_spelled(tmp_path, spelling):
    files = {
        "Barcodes": b"# subject barcode\n1 5\n6 7\n",
        "Landmark_Groundtruth": b"# subject x y dx dy\n6 1.0 2.0 0.1 0.1\n",
        "Robot1_Odometry": b"# t v w\n1.0 0.1 0.0\n",
        "Robot1_Measurement": b"# t barcode r b\n1.0 7 2.0 0.1\n",
    }
    for name, text in files.items():
        (tmp_path / f"{name}.dat").write_bytes(SPELLINGS[spelling](text))
    tables = read_tables(tmp_path)
    assert tables.barcodes == {5: 1, 7: 6}
    assert tables.landmarks.tolist() == [[6.0, 1.0, 2.0]]
    assert tables.logs[1].measurements.tolist() == [[1.0, 7.0, 2.0, 0.1]]
