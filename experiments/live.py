"""Records as they come, from a pipe or over the network: how soon are they answered by guaranteed regions?

Run `python -m experiments.live --help`, and see docs/live.md. The exit code is the guarantee, as of `experiments.follow`; 3 is
for a reader of the regions that has closed, 130 for Ctrl-C, after which there is a summary all the same.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import tyro

from experiments.feeds.answering import Answering, Feed
from experiments.feeds.answers import Answers
from experiments.feeds.beside import Beside
from experiments.feeds.intake import Batch, Intake, Source
from experiments.feeds.now import Now, gone_on
from experiments.feeds.reading import Reading
from experiments.feeds.sources import source_of
from experiments.feeds.tally import Tally
from experiments.feeds.truths import Truths
from experiments.feeds.watched import Watched
from experiments.feeds.words import Words
from experiments.following.metrics import Value
from experiments.following.steps import warmed_up
from experiments.following.tolerating import Tolerating
from experiments.keeping.running import exit_code
from experiments.keeping.watched import ALARMS, EPISODES, POSES, AlarmFiles, watch_summary
from experiments.logs import InvalidLog, first_belief
from experiments.regions import FILES
from experiments.show.command import STOPPED, command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import print_table, tell
from experiments.watchdog.claimed import claims_in
from experiments.watchdog.told import print_episodes, sentence, summary_of
from filter import Array, Budget, FixedLag, Inconsistent, InvalidInput, Policy, SetMembershipFilter, Team, Window

if TYPE_CHECKING:
    from experiments.feeds.pictures import Pictures

RECORDING = "live.rrd"
LEFT = (FILES["jsonl"], RECORDING, ALARMS, EPISODES)  # what an earlier run may have left, and this one may not write
TURN = 0.0005  # how long Python may keep the reading thread from taking the time of an arrival [s]


@dataclass(frozen=True)
class Options:
    """Answer records as they come by guaranteed regions.

    Records are lines as docs/log.md has them, the header and the initial sets first. Regions go to standard output and to
    regions.jsonl, see docs/regions.md; everything else is said on stderr. Exit code 0 only if the guarantee was in force all
    the time and no truth, where the feed tells it, was outside; 1 for one that was, for measurements proved to disagree, or
    for a watched pose that is proved wrong; 4 if the guarantee was suspended; 2 for bad input; 3 if regions could not be
    written, as their reader has closed; 130 for Ctrl-C.
    """

    source: Annotated[str, tyro.conf.arg(name="from", metavar="-|tcp://HOST:PORT|ws://HOST:PORT")] = "-"
    """Where records come from: - is standard input; at tcp://HOST:PORT and ws://HOST:PORT connections are waited for, one at a
    time, and a next one may go on. Without a host only this machine can connect; 0.0.0.0 is for everybody who reaches it."""
    connections: int | None = None
    """End after so many connections; by default there is no end but Ctrl-C."""
    out: Path = Path("runs/live")
    """Folder for the regions and the summary."""
    lag: float = 1.0
    """How late a measurement may be [s]; what is later is refused."""
    gap: float = 60.0
    """A stamp that is farther ahead is doubted, and refused; the next one that goes on from it is taken [s]."""
    every: float = 0.1
    """So long a time is one step [s]; 0 for a step at every stamp."""
    budget: float | None = 0.008
    """How long finding the regions may take [s]; who is not reached in time keeps a larger one. None for no end."""
    pause: float = 5.0
    """After so long without any record that is said [s]."""
    full: bool = False
    """Take all along from step to step, as experiments.follow does: regions smaller by a percent or so, later answers."""
    hops: int | None = None
    """Find each region in the window of the robots so many sightings away, not in the whole team; 1 does for large teams."""
    policy: Policy = "raise"
    """What to do when measurements are proved to disagree: raise (stop), or reject what is wrong: go on with what is known
    whichever one thing that is, until it is found out."""
    tolerating: tyro.conf.OmitArgPrefixes[Tolerating] = field(default_factory=Tolerating)
    """What may be wrong, all the time."""
    watch: Path | None = None
    """Hold another estimator's poses against the regions as their time comes: a TUM file, r0.tum or r0_slam.tum, or a folder of
    them, read at the start. What is proved wrong is said at once."""
    view: bool = False
    """Show what is answered in a live viewer; the answers never wait for it."""
    recording: bool = False
    """Record live.rrd, to look at with Rerun."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Answer with command-line arguments; return the exit code."""
    return command("live", Options, run, arguments, stopped="the regions end here, there is no summary")


def run(options: Options) -> int:
    """Answer what comes, to its end; return the exit code.

    Raises:
        CorralError: An option, the head of the feed or the output folder cannot be used.
        OSError: Something cannot be written.
    """
    _check(options)
    folder = output_folder(options.out)
    for name in LEFT:
        (folder / name).unlink(missing_ok=True)
    source = source_of(options.source, options.connections)
    warmed_up()  # before anything is taken in
    with _prompt():
        return Live(options, folder, source).run()


def _check(options: Options) -> None:
    """Refuse numbers that mean nothing; what filters take is checked by them."""
    if not 0 < options.pause < float("inf"):
        raise InvalidInput("a pause above 0 s", options.pause)
    if options.connections is not None and (options.connections < 1 or options.source == "-"):
        raise InvalidInput("one connection or more, over tcp or ws", options.connections)


def filter_of(options: Options, team: Team) -> SetMembershipFilter:
    """Return the filter that the options ask for; raises `InvalidInput` for numbers that mean nothing."""
    make = SetMembershipFilter if options.full else SetMembershipFilter.light
    scope = Window.everybody() if options.hops is None else Window(options.hops)
    budget = None if options.budget is None else Budget(options.budget, perf_counter)
    tolerance = options.tolerating.tolerance()
    return make(team, scope=scope, policy=options.policy, tolerance=tolerance, budget=budget, threads=1)


@contextmanager
def _prompt() -> Iterator[None]:
    """Let arrivals be noticed at once, and what was loaded never be looked through for garbage."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(TURN)
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
        sys.setswitchinterval(before)


class Live:
    """Listens to a source, and answers until it ends."""

    def __init__(self, options: Options, folder: Path, source: Source) -> None:
        self._options, self._folder, self._source = options, folder, source
        self._feed = Feed(Intake(), Reading(source.name), options.pause, Words(), Tally())
        self._answering: Answering | None = None
        self._watched: Watched | None = None

    def run(self) -> int:
        """Answer to the end, write the summary and tell it; return the exit code.

        Raises:
            InvalidInput: The head of the feed cannot be used, or there is none.
            OSError: Something cannot be written.
        """
        conflict, stopped = None, False
        self._feed.intake.start(self._source)
        batch = self._head()
        header = self._feed.reading.header
        names = tuple(map(header.team.name, range(header.team.robots)))
        try:
            with Answers(self._folder, names) as answers, ExitStack() as held:
                self._answering = self._begun(answers, held)
                self._through(self._answering, batch)
        except Inconsistent as error:
            conflict = header.team.words(error)
        except KeyboardInterrupt:
            stopped = True
        self._tell(conflict)
        if stopped:
            return STOPPED
        return 1 if self._watched and self._watched.judged.alarms else exit_code(self._feed.tally, conflict is not None)

    def _head(self) -> Batch:
        """Read until the initial sets are known; return what has come after them, together."""
        batch = Batch()
        while not self._feed.reading.initial:
            if batch.ended:
                raise InvalidLog(Path(self._source.name), 0, "a header and the initial sets", "the end of what came")
            batch = self._feed.batch()
            while batch.lines and not self._feed.reading.initial and self._feed.record(batch.lines[0]) is None:
                del batch.lines[0]
                self._feed.intake.answered(1)
        return batch

    def _begun(self, answers: Answers, held: ExitStack) -> Answering:
        """Start the filter with what the feed began with, and what goes on beside it."""
        options, reading = self._options, self._feed.reading
        filter_ = filter_of(options, reading.header.team)
        restart = partial(gone_on, filter_)
        lag = FixedLag(filter_, lag=options.lag, gap=options.gap, restart=restart, every=options.every)
        now = Now(lag, filter_, first_belief(filter_, reading.header, reading.initial))
        return Answering(self._feed, now, answers, Truths(filter_), list(self._besides(now, held)))

    def _besides(self, now: Now, held: ExitStack) -> Iterator[Beside]:
        """Yield what goes on beside the answers: first the watch, so that its alarms are in the pictures."""
        options, team, shown = self._options, self._feed.reading.header.team, None
        if options.view or options.recording:
            from experiments.feeds.pictures import pictures  # noqa: PLC0415 - Rerun is half a second that few need

            path = self._folder / RECORDING if options.recording else None
            shown = pictures(team, path, view=options.view)
            held.enter_context(shown)
        if options.watch:
            claims = claims_in(options.watch, POSES, team.robots, 0.0)
            self._watched = Watched(now, team, claims, AlarmFiles(self._folder), partial(self._alarm, shown))
            yield held.enter_context(self._watched)
        if shown:
            yield shown

    def _alarm(self, shown: Pictures | None, what: str, time: float, why: str, place: Array) -> None:
        self._feed.words.say(what, f"at {time:.3f} s {why}")
        if shown:
            shown.mark(what, time, why, place)

    def _through(self, answering: Answering, batch: Batch) -> None:
        while True:
            answering.take(batch.lines)
            self._feed.intake.answered(len(batch.lines))
            if batch.ended:
                return
            batch = self._feed.batch()

    def _tell(self, conflict: str | None) -> None:
        """Write the summary, and tell it."""
        self._feed.words.end()
        summary = self._summary(conflict)
        write_summary(self._folder, summary)
        shown = {name: value for name, value in summary.items() if value is not None}
        print_table(f"live, in {self._folder}", shown, stderr=True)
        tally = self._feed.tally
        if self._watched:
            print_episodes(self._watched.judged.episodes, stderr=True)
            tell(sentence(summary_of(self._watched.judged)))
        if conflict:
            tell(f"the filter stopped: {conflict}")
        if tally.suspended is not None:
            tell(f"the guarantee is {self._feed.reading.header.team.words(tally.suspended)}")
        if not tally.checks:
            tell("the feed told no truth: nothing was checked against it")

    def _summary(self, conflict: str | None) -> dict[str, Value]:
        options, tally, header = self._options, self._feed.tally, self._feed.reading.header
        answering = self._answering
        lagged, waiting = (answering.now.lagged, answering.waiting) if answering else (None, 0)
        tally.unchecked += waiting
        known: dict[str, Value] = {"robots": header.team.robots, "filter": "sets", "policy": options.policy}
        known |= {"from": options.source, "every_s": options.every, "lag_s": options.lag, "budget_s": options.budget}
        late, refused = (lagged.late, lagged.refused + tally.refused) if lagged else (0, 0)
        known |= tally.summary(header.team.words) | {"late": late, "refused": refused, "inconsistent": conflict}
        known["recording"] = RECORDING if options.recording else None
        if self._watched:
            known |= watch_summary(self._watched.judged) | {"watch_unjudged": self._watched.unjudged}
        return known


if __name__ == "__main__":
    sys.exit(main())
