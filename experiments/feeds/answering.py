"""The loop: what waits is merged at once, and answered by the regions that are known then."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter

from experiments.feeds.answers import Answers
from experiments.feeds.beside import Answered, Beside
from experiments.feeds.intake import Batch, Intake, Line
from experiments.feeds.now import Now
from experiments.feeds.reading import Reading
from experiments.feeds.tally import Tally
from experiments.feeds.truths import Truths
from experiments.feeds.words import Words
from experiments.following.checks import Escapes
from experiments.logs import InvalidLog, Record, TruthAt
from experiments.logs.gathering import arrival_of
from filter import Arrival, Frame, InvalidInput, OutOfOrder

BEHIND = 1.0  # so far behind is worth a word [s]


@dataclass(frozen=True)
class Feed:
    """Lines that come, and how they are read.

    Attributes:
        intake: Where they come from.
        reading: Reads them.
        pause: How long nothing may come before that is said [s].
        words: Says things.
        tally: Counts.
    """

    intake: Intake
    reading: Reading
    pause: float
    words: Words
    tally: Tally

    def batch(self) -> Batch:
        """Return what comes next, and say what there is to say of it; how long nothing comes is said once."""
        found = self.intake.batch(self.pause)
        if not (found.lines or found.words or found.ended):
            self.words.say("pause", f"nothing has come for {self.pause:g} s; waiting on")
            while not (found.lines or found.words or found.ended):
                found = self.intake.batch(self.pause)
        for words in found.words:
            self.words.say("feed", words)
        return found

    def record(self, line: Line) -> Record | None:
        """Return what a line says, if anything; what is wrong with it is said and counted.

        Raises:
            InvalidLog: It is of the head, of which all has to be right.
        """
        if line.text is None:
            self.tally.too_long += 1
            self.words.say("skipped", f"line {line.number}, which is too long")
        try:
            return self.reading.read(line)
        except InvalidLog:
            raise
        except InvalidInput as error:
            self.skipped(line, error)
            return None

    def skipped(self, line: Line, error: InvalidInput) -> None:
        """Say and count that a line is none."""
        self.tally.malformed += 1
        self.words.say("skipped", f"line {line.number}: {error}")


class Answering:
    """Merges what a feed brings, and answers.

    Attributes:
        now: What is known.
    """

    def __init__(self, feed: Feed, now: Now, answers: Answers, truths: Truths, besides: Sequence[Beside] = ()) -> None:
        self._feed, self._team, self._answers, self._truths = feed, feed.reading.header.team, answers, truths
        self.now, self._besides = now, besides
        self._behind = BEHIND  # what is worth the next word [s]

    @property
    def waiting(self) -> int:
        """How many truths wait for what the filter has not come to."""
        return self._truths.left

    def take(self, lines: Sequence[Line]) -> None:
        """Answer some lines: merge them, write the regions, and hold them against the truth.

        Raises:
            Inconsistent: What was measured is proved to disagree.
            OSError: Something cannot be written.
        """
        began, arrivals = perf_counter(), list[tuple[Line, Arrival]]()
        for line in lines:
            record = self._feed.record(line)
            if record is not None:
                arrivals += self._arrivals(line, record)
        if arrivals:
            self._merge([arrival for _, arrival in arrivals], arrivals)
            known = perf_counter()
            self._answers.write(self.now.belief)
            self._answered([line for line, _ in arrivals], known - began)
        answered = Answered(self.now, tuple(arrival for _, arrival in arrivals), tuple(self._check()))
        for beside in self._besides if answered.records or answered.checked else ():
            beside.keep(answered)

    def _arrivals(self, line: Line, record: Record) -> list[tuple[Line, Arrival]]:
        """Return a record as filters take it; truth is put aside."""
        try:
            arrival = arrival_of(record, self._team.robots)
        except InvalidInput as error:
            self._feed.skipped(line, error)
            return []
        self._feed.tally.count(record)
        if isinstance(record, TruthAt):
            self._truths.add(record)
            return []
        return [(line, arrival)]

    def _merge(self, records: Sequence[Arrival], arrivals: Sequence[tuple[Line, Arrival]]) -> None:
        """Merge records; if one of them cannot be, one by one."""
        before = self.now.lagged.refused
        try:
            self.now.take(records)
        except (InvalidInput, OutOfOrder) as error:
            if len(records) > 1:
                for line, record in arrivals:
                    self._merge([record], [(line, record)])
                return
            self._feed.tally.refused += 1
            self._feed.words.say("refused", f"line {arrivals[0][0].number}: {error}")
            return
        if self.now.lagged.refused > before:
            self._feed.words.say("refused", "; ".join(map(str, self.now.lagged.events)))

    def _answered(self, lines: Sequence[Line], seconds: float) -> None:
        """Take the time of answers that are written."""
        now, tally = perf_counter(), self._feed.tally
        for line in lines:
            tally.answered.add(now - line.arrived)
        tally.add(self.now.belief, seconds, now)
        if tally.behind > self._behind:
            self._behind = 2 * tally.behind
            self._feed.words.say("behind", f"answers are {tally.behind:.1f} s behind the stamps")

    def _check(self) -> Iterator[tuple[Frame, Escapes]]:
        """Hold what was answered against the truths that are due, and yield them with those that were outside."""
        due, left_out = self._truths.due(self.now)
        self._feed.tally.unchecked += left_out
        for belief, frame in due:
            escapes = self._feed.tally.check(belief, frame.truth) if frame.truth else Escapes()
            yield frame, escapes
            if escapes:
                names = [self._team.name(robot) for robot in sorted({*escapes.positions, *escapes.headings})]
                self._feed.words.say("escaped", f"{', '.join(names)} at {frame.time:.3f} s")
