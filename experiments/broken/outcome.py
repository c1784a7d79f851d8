"""What a filter makes of an episode: step by step, held against the truth and against what an independent judge can prove."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.broken.episodes import Episode
from experiments.broken.fault import KINDS, OF_INSTANTS, Fault, Kind
from experiments.broken.judge import Judge
from experiments.broken.named import innocents, named_by, names_the_culprit
from experiments.following.located import inside, outers
from experiments.following.metrics import rounded
from filter import Belief, Filter, Inconsistent, Mask, Polygon, SetMembershipFilter, Step, follow

SOON = 10  # good frames in which a filter has to get right


@dataclass(frozen=True)
class Case:
    """An episode by its number; its randomness is that of its kind's own numbers, whatever other kinds there are.

    Attributes:
        seed: Of the experiment.
        kind: Of its fault.
        number: Among those of its kind.
        landmarks: How many there are.
    """

    seed: int
    kind: Kind
    number: int
    landmarks: int

    def episode(self) -> Episode:
        """Draw the episode."""
        rng = np.random.default_rng([self.seed, KINDS.index(self.kind), self.number, self.landmarks])
        return Episode.drawn(rng, self.kind, self.landmarks)


@dataclass(frozen=True)
class Outcome:
    """What came of an episode.

    Attributes:
        fault: What was wrong.
        frames: How many frames there were.
        provable: Number of the first frame at which past and instant are proved to exclude each other; None if none is.
        outside_in_force: Frames in which a truth was outside while its guarantee was said to be in force: from the first
            provable one on, and before the fault, when nothing excuses it, nor the filter if it gives up.
        outside_before: The same between the fault and the first provable frame.
        suspended: Frames from the fault on in which the guarantee of some robot was suspended.
        without_cause: Frames before the fault in which it was, or somebody was named.
        first_right: Number of good frames before the first right one; None if there is none.
        right: Whether the filter was right soon enough, and at the end.
        named: Whether the culprit is named at the end.
        innocent: Whether somebody innocent is, then.
        gave_up: Whether the filter ended with an error.
        area_before: Area of a region in the last frame before the fault, the mean over the robots; None if there is none [m2].
        area_most: The same in the frame from the fault on in which it is largest; None if there is none [m2].
        area_end: The same in the last frame [m2].
    """

    fault: Fault
    frames: int
    provable: int | None
    outside_in_force: int
    outside_before: int
    suspended: int
    without_cause: int
    first_right: int | None
    right: bool
    named: bool
    innocent: bool
    gave_up: bool
    area_before: float | None
    area_most: float | None
    area_end: float | None


@dataclass(frozen=True, eq=False)
class Moment:
    """What a filter said in one frame.

    Attributes:
        outside: (n,) which robots are outside their region, or their heading outside its arc.
        in_force: (n,) for which robots the guarantee is said to be in force.
        named: Whether the culprit is named.
        innocent: Whether somebody innocent is.
        area: Of a region, the mean over the robots [m2].
    """

    outside: Mask
    in_force: Mask
    named: bool
    innocent: bool
    area: float

    @classmethod
    def of(cls, fault: Fault, step: Step[Belief]) -> Moment:
        """Hold a step against the truth."""
        belief, truth = step.belief, step.frame.truth
        if truth is None:
            raise ValueError("a frame of an episode knows the truth")
        within = inside(belief, truth.positions) & belief.headings.contains(truth.headings)
        named, area = named_by(belief), np.mean([outer.area for outer in outers(belief)])
        said = names_the_culprit(fault, named), bool(innocents(fault, named))
        return cls(~within, belief.guarantee.in_force, *said, rounded(float(area)))

    @property
    def broken(self) -> bool:
        """Whether a robot is outside although its guarantee is said to be in force."""
        return bool((self.outside & self.in_force).any())

    def is_right(self, *, lasting: bool) -> bool:
        """Return whether all is well: in force, the truth inside, nobody innocent named, and the culprit of what lasts."""
        well = self.in_force.all() and not self.outside.any() and not self.innocent
        return bool(well and (self.named or not lasting))


def filter_for(episode: Episode) -> SetMembershipFilter:
    """Return the filter that is judged: the one that lives with broken bounds."""
    return SetMembershipFilter(episode.team, policy="reject")


def steps_of(episode: Episode, filter_: Filter[Belief]) -> Iterator[Step[Belief]]:
    """Follow an episode, as far as the filter can."""
    belief = filter_.start(0.0, episode.positions, episode.headings)
    try:
        yield from follow(filter_, belief, episode.frames)
    except Inconsistent:
        return


def outcome_of(case: Case) -> Outcome:
    """Follow an episode, and judge what the filter made of it."""
    episode = case.episode()
    steps = list(steps_of(episode, filter_for(episode)))
    provable = first_provable(episode, steps)
    return judged(episode.fault, [Moment.of(episode.fault, step) for step in steps], len(episode.frames), provable)


def first_provable(episode: Episode, steps: Sequence[Step[Belief]]) -> int | None:
    """Return the first frame at which past and instant are proved to exclude each other, or None.

    The past is what the filter knew at the last frame before the fault; what it knew at the start, if that is wrong.
    """
    when = episode.fault.when
    if len(steps) < when:
        return None
    regions: Sequence[Polygon] = episode.positions
    headings = episode.headings
    if when:
        belief = steps[when - 1].belief
        regions, headings = outers(belief), belief.headings
    judge, last = Judge.of(episode.team, regions, headings), len(episode.frames)
    if episode.fault.kind in OF_INSTANTS:  # nothing is wrong any more when it is over, and nothing could be proved
        last = int(episode.fault.until)
    for number, frame in enumerate(episode.frames[when:last], when):
        judge = judge.after(frame)
        if judge.proves(frame):
            return number
    return None


def judged(fault: Fault, moments: Sequence[Moment], frames: int, provable: int | None) -> Outcome:
    """Return what came of an episode of so many frames; those after the last moment are the ones that a filter gave up."""
    excused = range(fault.when, frames if provable is None else provable)
    broken = [number for number, moment in enumerate(moments) if moment.broken]
    before = sum(number in excused for number in broken)
    rights = [moment.is_right(lasting=fault.lasts) for moment in moments[fault.settled :]]
    first = rights.index(True) if any(rights) else None
    gave_up, early = len(moments) < frames, moments[: fault.when]
    return Outcome(
        fault=fault,
        frames=frames,
        provable=provable,
        outside_in_force=len(broken) - before + fault.when - len(early),
        outside_before=before,
        suspended=sum(not moment.in_force.all() for moment in moments[fault.when :]),
        without_cause=sum(not moment.in_force.all() or moment.named or moment.innocent for moment in early),
        first_right=first,
        right=first is not None and first <= SOON and rights[-1] and not gave_up,
        named=bool(moments) and moments[-1].named,
        innocent=bool(moments) and moments[-1].innocent,
        gave_up=gave_up,
        area_before=early[-1].area if early else None,
        area_most=max((moment.area for moment in moments[fault.when :]), default=None),
        area_end=moments[-1].area if moments else None,
    )
