"""Live: what is answered, what is survived, what is said, and what the exit code says."""

import io
import json
import os
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from helpers.teams import write_log

import experiments.live
from experiments.feeds.lines import MOST
from experiments.follow import main as follow
from experiments.live import main

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("log") / "own.jsonl")


@pytest.fixture(scope="module")
def lines(log):
    return log.read_bytes().splitlines(keepends=True)


class Slow(io.RawIOBase):
    """Gives some bytes at a time, and waits where None is."""

    def __init__(self, parts):
        self._parts = list(parts)

    def readable(self):
        return True

    def readinto(self, buffer):
        part = self._parts.pop(0) if self._parts else b""
        if part is None:
            time.sleep(0.4)
            return self.readinto(buffer)
        some, rest = part[: len(buffer)], part[len(buffer) :]
        self._parts[:0] = [rest] if rest else []
        buffer[: len(some)] = some
        return len(some)


@pytest.fixture
def live(tmp_path, monkeypatch, capsys):
    """Run live on parts of bytes; return exit code, rows on stdout, summary, and what was said."""

    def run(*parts, options=()):
        stdin = io.TextIOWrapper(io.BufferedReader(Slow(parts), 1 << 21))
        monkeypatch.setattr(sys, "stdin", stdin)
        code = main(["--out", str(tmp_path / "out"), *options])
        said = capsys.readouterr()
        path = tmp_path / "out" / "summary.json"
        summary = json.loads(path.read_text()) if path.exists() else {}
        return code, [json.loads(line) for line in said.out.splitlines()], summary, said.err

    return run


def chunks(data, size=4000):
    return [data[k : k + size] for k in range(0, len(data), size)]


def test_it_answers_every_record_with_the_truth_inside(live, lines, tmp_path):
    code, rows, summary, _ = live(*chunks(b"".join(lines), 97))
    assert code == 0
    assert (summary["escapes"], summary["escapes_in_force"], summary["malformed"], summary["refused"]) == (0, 0, 0, 0)
    assert summary["checks"] > 0
    assert summary["records"] == len(lines) - 3
    assert summary["answer_median_ms"] <= summary["answer_p99_ms"] <= summary["answer_most_ms"]
    assert {row["robot"] for row in rows} == {"r0", "r1"}
    assert all(row["in_force"] for row in rows)
    assert [row["time"] for row in rows] == sorted(row["time"] for row in rows)
    written = (tmp_path / "out" / "regions.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in written] == rows


def test_the_last_regions_are_those_of_follow_bit_for_bit(live, log, lines, tmp_path, capsys):
    assert follow([str(log), "--every", "0", "--out", str(tmp_path / "followed")]) == 0
    wanted = [json.loads(line) for line in (tmp_path / "followed" / "regions.jsonl").read_text().splitlines()]
    capsys.readouterr()
    code, rows, _, _ = live(b"".join(lines), options=["--every", "0", "--full", "--budget", "None", "--lag", "100"])
    assert code == 0
    assert [{**row, "inner": None} for row in rows[-2:]] == [{**row, "inner": None} for row in wanted[-2:]]


def test_what_is_no_record_is_skipped_counted_and_said(live, lines):
    bad = [b"no json\n", b'{"record": "sonar", "time": 1.0}\n', b"\n", b'{"record": "compass"\n', b"\xff\xfe\n"]
    rest = b"".join(lines[6:]).replace(b"\n", b"\r\n")
    code, _, summary, said = live(b"\xef\xbb\xbf", b"".join(lines[:6]), b"".join(bad), rest)
    assert (code, summary["malformed"], summary["escapes"]) == (0, 4, 0)
    assert summary["records"] == len(lines) - 3
    assert "skipped: line 7: " in said
    assert len([line for line in said.splitlines() if line.startswith("skipped")]) <= 3


def test_a_line_without_end_is_skipped_and_what_follows_is_answered(live, lines):
    code, _, summary, said = live(b"".join(lines[:6]), *[b"x" * (1 << 19)] * 5, b"\n", b"".join(lines[6:]))
    assert (code, summary["too_long"], summary["malformed"]) == (0, 1, 0)
    assert summary["records"] == len(lines) - 3
    assert "line 7, which is too long" in said
    assert MOST < 5 * (1 << 19)


def test_a_last_line_that_is_cut_off_is_skipped(live, lines):
    code, _, summary, _ = live(b"".join(lines)[:-20])
    assert (code, summary["malformed"]) == (0, 1)


def test_late_records_are_merged_and_those_that_are_too_late_are_refused(live, lines):
    compass = next(line for line in lines if b'"compass"' in line)
    rest = [line for line in lines if line is not compass]
    code, _, summary, _ = live(b"".join(rest), compass, options=["--lag", "100"])
    assert (code, summary["escapes"], summary["refused"]) == (0, 0, 0)
    assert summary["late"] > 0
    code, _, summary, said = live(b"".join(rest), compass, options=["--lag", "0.05"])
    assert (code, summary["escapes"]) == (0, 0)
    assert summary["refused"] > 0
    assert "refused: " in said


def test_a_pause_is_said_once_and_waited_for(live, lines):
    middle = len(lines) // 2
    parts = b"".join(lines[:middle]), None, b"".join(lines[middle:])
    code, _, summary, said = live(*parts, options=["--pause", "0.1"])
    assert (code, summary["records"]) == (0, len(lines) - 3)
    assert said.count("nothing has come for 0.1 s; waiting on") == 1


def test_after_a_jump_of_stamps_robots_have_moved_within_their_limits(live, lines):
    later = [json.loads(line) for line in lines if b'"compass"' in line or b'"range"' in line]
    for record in later:
        record["time"] += 1000
    code, rows, summary, _ = live(b"".join(lines), "".join(json.dumps(record) + "\n" for record in later).encode())
    assert code == 0
    assert rows[-1]["time"] == max(record["time"] for record in later)
    assert summary["refused"] > 0


def test_robots_may_join_leave_and_come_back_wherever_they_have_been(live):
    """Whoever is carried is not followed on its way, and nothing is held against that."""

    def told(record, time, **fields):
        return (json.dumps({"record": record, "time": time, **fields}) + "\n").encode()

    def bob(time, x):
        return told("initial", time, robot="bob", vertices=[[x - 1, -1], [x + 1, -1], [x, 1]], heading=None)

    def truth(time, x):
        return told("truth", time, positions=[[0, 0], [x, 0]], headings=[0, 0])

    head = {"record": "header", "format": "corral-log", "version": 2, "robots": ["alice", "bob"], "landmarks": [[0, 2]]}
    head |= {"arena": [[None, None], [None, None]], "speed_limit": 0.5, "turn_rate_limit": 1.5, "start": 0.0}
    alice = {"record": "initial", "robot": "alice", "vertices": [[-1, -1], [1, -1], [0, 1]], "heading": None}
    seen = [told("range", 0.2 * k, robot="alice", landmark=0, range=2.0, bound=0.1, relative_bound=0) for k in range(1, 41)]
    between = {2: truth(0.5, 70), 5: bob(1.1, 8), 6: truth(1.3, 8), 10: told("leave", 2.1, robot="bob")}
    between |= {12: truth(2.5, -30), 20: bob(4.1, -9), 21: truth(4.3, -9), 30: bob(6.1, 50), 31: truth(6.3, 50)}
    lines = [json.dumps(each).encode() + b"\n" for each in (head, alice)]
    for k, line in enumerate(seen):
        lines += [line, *([between[k]] if k in between else [])]
    code, rows, summary, said = live(b"".join(lines), options=["--lag", "3"])
    assert code == 0, said
    assert (summary["escapes"], summary["heading_escapes"], summary["guarantee_in_force"]) == (0, 0, True)
    assert (summary["malformed"], summary["refused"]) == (0, 0)
    assert summary["checks"] >= 4
    times = [row["time"] for row in rows if row["robot"] == "bob"]
    assert min(times) >= 1.1
    assert not [time for time in times if 2.5 <= time < 4.1]  # that it had left was told late
    assert max(times) > 7


@pytest.mark.parametrize("data", [b"", b"\n\n", b"no header\n", b'{"record": "frame", "time": 0}\n'])
def test_a_feed_without_head_ends_with_2(live, data):
    code, rows, summary, said = live(data)
    assert (code, rows, summary) == (2, [], {})
    assert "standard input" in said


def test_a_head_that_is_cut_off_or_too_long_ends_with_2(live, lines):
    assert live(lines[0], lines[1])[0] == 2
    assert live(lines[0], *[b"x" * (1 << 20)] * 2, b"\n")[0] == 2


@pytest.mark.parametrize(
    "option", [["--from", "udp://:1"], ["--pause", "0"], ["--connections", "1"], ["--lag", "-1"], ["--every", "-1"]]
)
def test_options_that_mean_nothing_end_with_2(live, lines, option):
    assert live(b"".join(lines), options=option)[0] == 2


def test_a_lie_stops_with_1_or_is_rejected_with_4(live, lines):
    compass = json.loads(next(line for line in reversed(lines) if b'"compass"' in line))
    lie = json.dumps({**compass, "heading": [value + 1.0 for value in compass["heading"]]}).encode() + b"\n"
    code, _, summary, said = live(b"".join(lines), lie)
    assert code == 1
    assert summary["inconsistent"]
    assert "the filter stopped" in said
    code, _, summary, _ = live(b"".join(lines), lie, options=["--policy", "reject"])
    assert (code, summary["inconsistent"], summary["guarantee_in_force"]) == (4, None, False)


def test_a_truth_outside_ends_with_1_and_is_said(live, lines):
    told = [json.loads(line) if b'"truth"' in line else None for line in lines]
    wrong = max(k for k, record in enumerate(told) if record)
    told[wrong]["positions"][0] = [50.0, 50.0]
    lines = [*lines[:wrong], json.dumps(told[wrong]).encode() + b"\n", *lines[wrong + 1 :]]
    code, _, summary, said = live(b"".join(lines))
    assert (code, summary["escapes_in_force"]) == (1, 1)
    assert "escaped: r0 at" in said


def test_ctrl_c_ends_with_130_and_a_summary(live, lines, monkeypatch):
    original = experiments.live.Answering.take

    def take(self, given):
        original(self, given)
        raise KeyboardInterrupt

    monkeypatch.setattr(experiments.live.Answering, "take", take)
    code, rows, summary, _ = live(b"".join(lines))
    assert code == 130
    assert summary["records"] < len(lines)
    assert len(rows) in (0, 2)


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def connected(port):
    for _ in range(600):
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            time.sleep(0.1)
    raise TimeoutError


def test_over_tcp_the_next_connection_goes_on_where_the_one_before_ended(tmp_path, lines, capsys):
    port, middle = free_port(), len(lines) // 2

    def send():
        with connected(port) as first:
            first.sendall(b"".join(lines[:middle])[:-5])
        with connected(port) as second:
            second.sendall(b"".join(lines[:3]) + b"".join(lines[middle:]))

    sending = threading.Thread(target=send)
    sending.start()
    code = main(["--from", f"tcp://127.0.0.1:{port}", "--connections", "2", "--out", str(tmp_path)])
    sending.join()
    summary, said = json.loads((tmp_path / "summary.json").read_text()), capsys.readouterr().err
    assert (code, summary["malformed"], summary["records"], summary["escapes"]) == (0, 1, len(lines) - 4, 0)
    assert f"listening on tcp, 127.0.0.1:{port}" in said


def test_over_a_websocket_a_message_is_a_line_or_several(tmp_path, lines):
    client = pytest.importorskip("websockets.sync.client")
    port = free_port()

    def send():
        connected(port).close()
        with client.connect(f"ws://127.0.0.1:{port}", compression=None) as first:
            first.send(b"".join(lines[:5]).decode())
            for line in lines[5:]:
                first.send(line.strip())

    sending = threading.Thread(target=send)
    sending.start()
    code = main(["--from", f"ws://127.0.0.1:{port}", "--connections", "1", "--out", str(tmp_path)])
    sending.join()
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (code, summary["malformed"], summary["records"]) == (0, 0, len(lines) - 3)


def test_without_the_package_a_websocket_is_refused(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("experiments.feeds.sources.find_spec", lambda name: None)
    assert main(["--from", "ws://127.0.0.1:0", "--out", str(tmp_path)]) == 2
    assert "websockets" in capsys.readouterr().err


def test_a_reader_that_closes_ends_the_run_with_3_and_whole_lines(log, tmp_path):
    command, environment = [sys.executable, "-m", "experiments.live", "--out", str(tmp_path)], {**os.environ, "PYTHONPATH": "."}
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen(command, cwd=ROOT, env=environment, **pipes) as run:
        run.stdin.write(log.read_bytes())
        run.stdin.flush()  # and it stays open
        assert json.loads(run.stdout.readline())["robot"] == "r0"
        run.stdout.close()
        with suppress(BrokenPipeError):  # the run may be over
            run.stdin.write(log.read_bytes().splitlines(keepends=True)[-1])
            run.stdin.flush()
        said = run.stderr.read().decode()
        assert run.wait() == 3
    assert "standard output: " in said
    assert "Traceback" not in said
    assert all(json.loads(line) for line in (tmp_path / "regions.jsonl").read_text().splitlines())
