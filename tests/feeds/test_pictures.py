"""Pictures of a feed: they show what was answered, and no viewer, whatever becomes of it, keeps an answer from coming."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from threading import Event
from time import perf_counter

import numpy as np
import pytest
from helpers.feeds.viewers import viewer
from helpers.recordings import rerun, rows_of
from helpers.teams import write_log

import experiments.feeds.pictures
import experiments.show.onlooker
from experiments.feeds.beside import Answered
from experiments.feeds.now import Now
from experiments.feeds.pictures import MARKED, Pictures
from experiments.following.checks import Escapes
from experiments.live import main
from experiments.logs import tum_line
from experiments.show.onlooker import MOST, Onlooker
from experiments.show.recording import Recording
from experiments.show.viewer import NoViewer
from filter import Fallback, FixedLag, Frame, Left, Polygon, Position, SetMembershipFilter, Team

ROOT = Path(__file__).parents[2]
TEAM = Team(2, landmarks=[[0.0, 1.0]], arena=[[-2, -2], [2, 2]])
NO_WALLS = np.zeros((0, 4))


def opened(path, **options):
    return Recording(path, TEAM, recording_id="test", walls=NO_WALLS, wall_height=0.0, live=True, **options)


def belief_at(time):
    return SetMembershipFilter(TEAM).start(time, [Polygon.box([0, 0], [1, 1]), Polygon.box([-1, -1], [0, 0])])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A feed that was answered with a recording and a watch: what came out, and its truths; r1 is claimed to be far away."""
    folder = tmp_path_factory.mktemp("run")
    lines = write_log(folder / "own.jsonl").read_bytes()
    truths = [record for record in map(json.loads, lines.splitlines()) if record["record"] == "truth"]
    poses = [tum_line(truth["time"], np.array(truth["positions"][1]) + 5.0, 0.0) for truth in truths]
    (folder / "r1_slam.tum").write_text("".join(poses))
    with pytest.MonkeyPatch.context() as patched, (folder / "own.jsonl").open() as feed:
        patched.setattr(sys, "stdin", feed)
        patched.setattr(experiments.feeds.pictures, "SHARE", np.inf)  # every answer has its picture
        code = main(["--recording", "--watch", str(folder / "r1_slam.tum"), "--out", str(folder / "out")])
    return code, folder / "out", truths


def test_the_recording_shows_the_answers_and_the_truth_at_its_own_stamps(run):
    _, folder, truths = run
    assert rerun("verify", folder / "live.rrd").returncode == 0
    said = [json.loads(line) for line in (folder / "regions.jsonl").read_text().splitlines()]
    for robot in ("r0", "r1"):
        drawn = rows_of(folder / "live.rrd", f"/world/outer/{robot}", "LineStrips3D:strips")
        answers = [row for row in said if row["robot"] == robot]
        assert [row["t"].total_seconds() for row in drawn] == pytest.approx([row["time"] for row in answers])
        for row, answer in zip(drawn, answers, strict=True):
            assert np.allclose(np.array(row["value"][0])[:-1, :2], answer["outer"], atol=1e-5)
    drawn = rows_of(folder / "live.rrd", "/world/truth/r1", "Points3D:positions")
    times = {round(truth["time"], 6): truth["positions"][1] for truth in truths}
    assert drawn
    for row in drawn:
        assert np.allclose(row["value"][0][:2], times[round(row["t"].total_seconds(), 6)], atol=1e-5)


def test_what_is_proved_wrong_is_said_counted_and_marked_and_its_begin_is_an_event(run):
    code, folder, truths = run
    summary = json.loads((folder / "summary.json").read_text())
    assert code == 1
    assert (summary["watch_poses"], summary["watch_checks"], summary["watch_alarms"]) == (len(truths),) * 3
    assert (summary["watch_episodes"], summary["watch_unjudged"], summary["escapes"]) == (1, 0, 0)
    assert summary["recording"] == "live.rrd"
    marks = [row["value"] for row in rows_of(folder / "live.rrd", "/world/impossible", "Points3D:positions") if row["value"]]
    assert marks
    assert all(any(np.allclose(mark[0][:2], np.add(truth["positions"][1], 5), atol=1e-5) for truth in truths) for mark in marks)
    events = [row["value"][0] for row in rows_of(folder / "live.rrd", "/events", "TextLog:text")]
    assert sum("r1_slam is proved wrong: by" in words for words in events) == 1


class Kept:
    """Keeps what would be drawn."""

    def __init__(self):
        self.frames, self.beliefs, self.marks, self.events, self.truths = [], [], [], [], []

    def add(self, frame, belief):
        self.frames.append(frame)
        self.beliefs.append(belief)

    def event(self, words, level="INFO"):
        self.events.append(words)

    def impossible(self, places):
        self.marks.append(len(places))

    def truth(self, frame):
        self.truths.append(frame.time)

    def close(self):
        self.events.append("closed")


def answered(time, *records, checked=()):
    filter_ = SetMembershipFilter(TEAM)
    now = Now(FixedLag(filter_), filter_, belief_at(time))
    return Answered(now, records, checked)


def test_pictures_take_their_share_of_the_time_and_no_more_and_lose_nothing(monkeypatch):
    clock, kept = [0.0], Kept()
    monkeypatch.setattr(experiments.feeds.pictures, "perf_counter", lambda: clock[0])

    def add(frame, belief):
        Kept.add(kept, frame, belief)
        clock[0] += 1.0

    monkeypatch.setattr(kept, "add", add)
    pictures = Pictures(kept, TEAM)
    box = Polygon.box([0, 0], [1, 1])
    for k in range(20):
        pictures.keep(answered(float(k), Position.within(float(k), 0, box), checked=((Frame(k - 0.5), Escapes((0,), ())),)))
        clock[0] += 1.0
    pictures.__exit__(None, None, None)
    assert len(kept.frames) == 5  # a second each, and four seconds until the next one; and the last one
    assert sum(len(frame.measurements) for frame in kept.frames) == 20
    assert kept.frames[-1].time == 19.0
    assert kept.truths == [k - 0.5 for k in range(20)]
    assert kept.events.count("r0: the position escaped") == 5
    assert kept.events[-1] == "closed"


def test_what_has_happened_is_told_once_though_a_step_that_goes_on_says_it_again(monkeypatch):
    kept, pending = Kept(), []
    monkeypatch.setattr(kept, "add", lambda frame, belief: pending.append([str(event) for event in belief.events]))
    pictures = Pictures(kept, TEAM)
    events = [Fallback(robot, ("walk",), None) for robot in (0, 1)]
    for known in (events[:1], events[:1], events, [], events[:1]):
        now = answered(0.0).now
        now.belief = replace(now.belief, events=tuple(known))
        monkeypatch.setattr(pictures, "_next", 0.0)
        pictures.keep(Answered(now, (), ()))
    assert [len(each) for each in pending] == [1, 0, 1, 0, 1]


def test_a_mark_stays_for_a_moment_and_one_begin_is_one_event():
    kept = Kept()
    pictures = Pictures(kept, TEAM)
    for time in (0.0, 0.1, 0.2):
        pictures.mark("r0 is proved wrong", time, "by 1 m", np.zeros(2))
        pictures._draw(belief_at(time))
    for time in (0.2 + MARKED / 2, 0.2 + 1.1 * MARKED, 0.2 + 2 * MARKED):
        pictures._draw(belief_at(time))
    pictures.mark("r0 is proved wrong", 3.0, "by 2 m", np.zeros(2))
    pictures._draw(belief_at(3.0))
    assert kept.marks == [1, 1, 1, 1, 0, 1]
    assert [words for words in kept.events if "wrong" in words] == ["r0 is proved wrong: by 1 m", "r0 is proved wrong: by 2 m"]


def test_who_leaves_is_told(monkeypatch):
    kept = Kept()
    Pictures(kept, TEAM).keep(answered(1.0, Left(1.0, 1)))
    assert "r1 has left" in kept.events


class Stuck:
    """A stream into a viewer that does not read until it is let, or that fails."""

    def __init__(self, error=None):
        self.let, self.error, self.got = Event(), error, []

    def flush(self, timeout_sec):
        self.let.wait(30)
        if self.error:
            raise self.error

    def disconnect(self):
        self.got.append("end")


def test_a_viewer_that_is_behind_misses_some_but_not_how_things_look():
    stream = Stuck()
    onlooker, began = Onlooker(lambda: stream, 0.0), perf_counter()
    for k in range(4 * MOST):
        onlooker.show(lambda stream, k=k: stream.got.append(k))
    onlooker.show(lambda stream: stream.got.append("looks"), for_sure=True)
    assert perf_counter() - began < 5
    stream.let.set()
    onlooker.close()
    assert stream.got[-2:] == ["looks", "end"]
    assert len(stream.got) == 4 * MOST + 2 - onlooker.missed
    assert onlooker.missed >= 2 * MOST


def test_a_run_that_is_not_live_waits_for_a_viewer():
    stream = Stuck()
    onlooker = Onlooker(lambda: stream, 60.0)
    stream.let.set()
    for k in range(4 * MOST):
        onlooker.show(lambda stream, k=k: stream.got.append(k))
    onlooker.close()
    assert (onlooker.missed, stream.got) == (0, [*range(4 * MOST), "end"])


def test_a_viewer_that_is_gone_is_told_once_and_nothing_waits_for_it(capfd, monkeypatch):
    monkeypatch.setattr("atexit.unregister", lambda function: None)
    stream = Stuck(RuntimeError("severed"))
    stream.let.set()
    onlooker, began = Onlooker(lambda: stream, 60.0), perf_counter()
    onlooker.show(lambda stream: None)
    while not onlooker.gone:
        assert perf_counter() - began < 10
    for _ in range(4 * MOST):
        onlooker.show(lambda stream: stream.got.append("late"))
    onlooker.close()
    assert perf_counter() - began < 10
    assert stream.got == []
    assert capfd.readouterr().err.count("the viewer does not receive any more: the run goes on without it") == 1


@pytest.mark.parametrize("what", ["freeze", "kill"])
def test_a_viewer_that_dies_keeps_nothing_from_the_file(what, tmp_path, monkeypatch):
    monkeypatch.setattr("atexit.unregister", lambda function: None)
    monkeypatch.setattr(experiments.show.onlooker, "PATIENCE", 0.5)
    path = tmp_path / "live.rrd"
    with viewer() as looking, opened(path, viewer=looking.address) as recording:
        for k in range(300):
            if k == 50:
                getattr(looking, what)()
            began = perf_counter()
            recording.add(Frame(0.1 * k), belief_at(0.1 * k))
            assert perf_counter() - began < 5
    assert rerun("verify", path).returncode == 0
    assert len(rows_of(path, "/world/outer/r0", "LineStrips3D:strips")) == 300


def test_a_viewer_alone_leaves_no_file_and_the_process_ends_though_it_is_frozen(tmp_path):
    log = write_log(tmp_path / "own.jsonl")
    program = "import sys, experiments.show.viewer as v, experiments.show.onlooker as o, experiments.live as live;"
    program += "v.PORT, o.PATIENCE = int(sys.argv[1]), 1.0; sys.exit(live.main(sys.argv[2:]))"
    with viewer() as looking, log.open("rb") as feed:
        looking.freeze()
        arguments = [str(looking.port), "--view", "--out", str(tmp_path / "out")]
        done = subprocess.run(
            [sys.executable, "-c", program, *arguments], stdin=feed, capture_output=True, cwd=ROOT, timeout=300, check=False
        )
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "out" / "live.rrd").exists()
    assert done.stdout.count(b"\n") == len((tmp_path / "out" / "regions.jsonl").read_text().splitlines()) > 0


def test_a_viewer_that_cannot_be_opened_is_told(tmp_path, monkeypatch, capsys):
    def nothing():
        raise NoViewer("none here")

    monkeypatch.setattr(experiments.feeds.pictures, "open_viewer", nothing)
    with write_log(tmp_path / "own.jsonl").open() as feed:
        monkeypatch.setattr(sys, "stdin", feed)
        assert main(["--view", "--out", str(tmp_path / "out")]) == 2
    assert "no live viewer (none here)" in capsys.readouterr().err
