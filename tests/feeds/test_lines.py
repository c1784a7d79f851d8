"""Lines, wherever they were split on their way; spreads; and a few words instead of a flood."""

import numpy as np
import pytest

from experiments.feeds.intake import Batch, Intake
from experiments.feeds.lines import Lines
from experiments.feeds.sources import source_of
from experiments.feeds.spread import Spread
from experiments.feeds.words import Words
from filter import InvalidInput

TEXT = b'{"a": 1}\r\n\n' + "é\n".encode() + b"the last one"
WHOLE = [b'{"a": 1}\r\n', b"\n", "é\n".encode(), b"the last one"]


@pytest.mark.parametrize("size", [1, 2, 3, 7, 100])
def test_lines_may_be_split_at_any_byte(size):
    lines = Lines()
    found = [line for k in range(0, len(TEXT), size) for line in lines.of(TEXT[k : k + size])]
    assert [*found, *lines.end()] == WHOLE
    assert list(lines.end()) == []


def test_a_line_without_end_costs_no_memory_and_what_follows_is_read():
    lines = Lines(most=10)
    assert [line for _ in range(1000) for line in lines.of(b"x" * 100)] == []
    assert len(lines._kept) == 0
    assert list(lines.of(b"x\nnext\n" + b"y" * 10 + b"\n" + b"z" * 11)) == [None, b"next\n", b"y" * 10 + b"\n"]
    assert list(lines.end()) == [None]


def test_there_is_room_for_few_lines_and_who_sends_more_waits():
    class Flood:
        name = "flood"

        def run(self, intake):
            for _ in range(100):
                intake.heard(b"line\n")
            intake.over()

    intake, came = Intake(room=4), []
    intake.start(Flood())
    batch = Batch()
    while not batch.ended:
        batch = intake.batch(5.0)
        assert len(batch.lines) <= 4
        assert not intake.batch(0.02).lines or batch.ended, "nothing more is let in before there is room"
        came += [line.number for line in batch.lines]
        intake.answered(len(batch.lines))
        if len(came) == 100:
            break
    assert came == list(range(1, 101))


def test_a_source_that_fails_is_told_and_ends():
    class Failing:
        name = "radio"

        def run(self, intake):
            raise ConnectionResetError(104, "reset")

    intake = Intake()
    intake.start(Failing())
    batch = intake.batch(5.0)
    assert (batch.words, batch.ended) == (["radio: reset"], True)


def test_a_pause_is_an_empty_batch():
    batch = Intake().batch(0.01)
    assert (batch.lines, batch.words, batch.ended) == ([], [], False)


@pytest.mark.parametrize("place", ["tcp://", "tcp://host", "udp://:1", "tcp://:99999", "file.jsonl", "", "tcp://:1/path"])
def test_a_place_that_is_none_is_refused(place):
    with pytest.raises(InvalidInput):
        source_of(place, None)


def test_a_port_that_is_taken_is_refused():
    taken = source_of("tcp://127.0.0.1:0", 1)
    with pytest.raises(InvalidInput, match="listen"):
        source_of(f"tcp://{taken.name}", 1)
    assert taken.name.startswith("127.0.0.1:")
    taken._server.close()


def test_without_a_host_it_is_this_machine_alone():
    source = source_of("tcp://:0", 1)
    assert source.name.startswith("127.0.0.1:")
    source._server.close()


def test_a_spread_tells_quantiles_to_a_percent_and_never_too_little():
    values = np.random.default_rng(0).lognormal(-4, 2, 5000)
    spread = Spread()
    for value in values:
        spread.add(float(value))
    for share in (0.01, 0.5, 0.99, 1.0):
        wanted = np.quantile(values, share, method="inverted_cdf")
        assert wanted * (1 - 1e-9) <= spread.quantile(share) <= 1.0101 * wanted
    assert (spread.count, spread.most) == (5000, values.max())
    assert spread.mean() == pytest.approx(values.mean())
    assert (Spread().mean(), Spread().quantile(0.5)) == (None, None)


def test_zero_and_what_is_huge_are_counted_at_the_ends():
    spread = Spread()
    for value in (0.0, 1e300):
        spread.add(value)
    assert (spread.count, spread.quantile(1.0)) == (2, pytest.approx(1e9, rel=0.02))


def test_words_of_a_kind_come_now_and_then_and_tell_what_was_not_said(capsys):
    now = [0.0]
    words = Words(lambda: now[0])
    for k in range(1000):
        now[0] = 0.01 * k
        words.say("skipped", f"line {k}")
    words.say("feed", "closed")
    words.end()
    said = capsys.readouterr().err.splitlines()
    assert len(said) <= 13
    assert said[0] == "skipped: line 0"
    assert "99 more" in said[1]
    assert "feed: closed" in said
