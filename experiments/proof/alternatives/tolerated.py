"""What is known in each case of who lies, as long as no more do than is tolerated. Standard library only.

In a window there is a case for each choice of so many of those who have spoken since it began; nobody who has not spoken can
have lied. Each has a chain of its own, which does not hear them, or of their ranges only that they are too long. A case begins
when one of its suspects speaks for the first time, from the case without those who do: until then both have heard the same. It
ends where nothing is left of it. When a window ends all cases become one, of what holds in each of them.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from math import comb

from experiments.proof.alternatives.cover import Cover, covered
from experiments.proof.alternatives.tolerance import Tolerance
from experiments.proof.alternatives.wrong import Wrong, everybody, without, words, wrong_in
from experiments.proof.cases.slices import Slice, TakenAlong, are_within, slices_in
from experiments.proof.chain import Chain, Placed
from experiments.proof.exact import are_apart, in_common
from experiments.proof.given.frame import Frame, Reading
from experiments.proof.given.log import Log
from experiments.proof.measured import between
from experiments.proof.reading import Broken, Record, body, located
from experiments.proof.share import Share

UNITED, LYING = "united", "lying"  # what the kinds of records have
Case = frozenset[Wrong]  # who lies in it
NOBODY_LIES = Case()


class Tolerated:
    """Checks one step after the other, in each case.

    Attributes:
        waiting: Robots that have started over: none.
        links: How many links of each kind were proved in this process's share.
    """

    def __init__(self, log: Log, tolerance: Tolerance, share: Share | None = None) -> None:
        """Take what was given to the filter, what is tolerated, and whose share it is."""
        self._log, self._tolerance, self._share = log, tolerance, share or Share()
        first = Chain(log, self._share)
        self.waiting, self.links = frozenset[int](), first.links
        self._living, self._heard = {NOBODY_LIES: first}, set[Wrong]()
        self._since, self._windows, self._frames = log.frames[0].time, 1, 0

    def on_trust(self) -> Counter[str]:
        """Return in words what the rest follows from, and how many windows there were."""
        return Counter({f"on trust: windows in which that holds: {self._tolerance.words}": self._windows})

    def check(self, headings: Sequence[Placed], lines: Sequence[Placed], told: Sequence[Placed]) -> Cover:
        """Check the next step, with what is told of cases; return what is said, which holds in each of them.

        Raises:
            Broken: Something does not follow, a case is missing, or a window is too long.
        """
        frame = self._log.frames[self._frames]
        with located(f"in the cases of who lies, at t = {frame.time} s"):
            for place, record in told:
                if UNITED in record:
                    with located(place):
                        self._unite(record, frame.time)
            if frame.time - self._since > self._tolerance.window:
                raise Broken(f"a window that began at t = {self._since} s, and has not ended")
            self._go_on(frame, [each for each in told if UNITED not in each[1]])
            self._frames += 1
            return covered(headings, lines, list(self._living.values()), is_mine=self._share.has_next())

    def _go_on(self, frame: Frame, told: Sequence[Placed]) -> None:
        """Check a step of each case, and that none is missing."""
        new = self._speaking(frame) - self._heard
        self._heard |= new
        found, needed = dict[Case, Chain](), self._count(len(new))
        if len(told) < needed:
            raise Broken(f"{len(told)} cases, where there are {needed}")
        for place, record in told:
            with located(place):
                case = self._case(record)
                if case in found or case - new not in self._living or len(case) > self._tolerance.most:
                    raise Broken(f"a case that there is not, or is there already: {self._words(case)}")
                found[case] = self._heard_in(case, self._living[case - new], frame, record)
        self._living = {case: chain for case, chain in found.items() if not chain.is_empty}
        if not self._living:
            raise Broken("no case is left: more lie than are tolerated")

    def _speaking(self, frame: Frame) -> set[Wrong]:
        """Return who says something in a frame and may lie."""
        heard = replace(frame.only("range"), places={}) if self._tolerance.is_long else frame
        return {one for one in everybody([heard], self._log.robots) if one[0] in self._tolerance.kinds}

    def _count(self, new: int) -> int:
        """Return how many cases there are when so many speak for the first time: some of them lie, or nobody, in each."""
        return sum(comb(new, k) for case in self._living for k in range(self._tolerance.most - len(case) + 1))

    def _case(self, record: Record) -> Case:
        return frozenset(wrong_in(self._log, each) for each in record[LYING])

    def _heard_in(self, case: Case, before: Chain, frame: Frame, record: Record) -> Chain:
        """Return what is proved in a case after a frame, of which it does not hear who lies in it."""
        chain = before.branch(self._frames)
        left_out = farther if self._tolerance.is_long else without
        own, lines = ([("", one) for one in record[name]] for name in ("headings", "lines"))
        chain.check(own, lines, reduce(left_out, sorted(case), frame))
        return chain

    def _unite(self, record: Record, time: float) -> None:
        """Take in that a window begins from what is said of all cases, as that holds in each of them."""
        told = {self._case(each): each["lines"] for each in record[UNITED]}
        if told.keys() != self._living.keys():
            raise Broken("other cases become one than there are")
        chains = [_seen_in(chain, told[case]) for case, chain in self._living.items()] if len(told) > 1 else []
        self._living = {NOBODY_LIES: self._together(record, chains) if chains else next(iter(self._living.values()))}
        self._heard, self._since, self._windows = set(), time, self._windows + 1

    def _together(self, record: Record, chains: Sequence[Chain]) -> Chain:
        """Return what goes on from several cases, of what is said in a record and nothing else."""
        own, lines = ([("", one) for one in record[name]] for name in ("headings", "lines"))
        is_mine, slices = self._share.has_next(), dict[int, TakenAlong]()
        cover = covered(own, lines, chains, is_mine=is_mine)
        for each in record["slices"]:
            robot = body(each["robot"], self._log.robots)
            slices[robot] = TakenAlong(each, self._frames - 1)
            if is_mine and not all(_are_around(slices_in(each, "slices"), robot, chain) for chain in chains):
                raise Broken(f"slices of robot {robot} that are less than can be in one of the cases")
        return chains[0].begun(cover.headings, cover.shown, slices)

    def _words(self, case: Case) -> str:
        return ", ".join(words(self._log, each) for each in sorted(case)) or "nobody"


def farther(frame: Frame, liar: Wrong) -> Frame:
    """Return a frame in which what a liar measured of ranges says no more than that targets are no farther."""
    believed = without(frame, liar).readings
    readings = {
        who: [_no_farther(one) for one in some] if who[0] == "range" and who not in believed else some
        for who, some in frame.readings.items()
    }
    return replace(frame, readings=readings)


def _no_farther(reading: Reading) -> Reading:
    half = between(reading)[1] / 2
    return replace(reading, value=half, bound=half, share=Fraction(0))


def _seen_in(chain: Chain, lines: Sequence[Record]) -> Chain:
    """Return what is proved in a case, with what is said besides of where robots are, seen from others."""
    other = chain.branch(chain.frames)
    shown = other.shown
    other.go_on([], [("", line) for line in lines])
    other.shown = {**shown, **other.shown}
    return other


def _are_around(slices: Sequence[Slice], robot: int, chain: Chain) -> bool:
    """Return whether slices are around the poses of a robot that are left in a case, with the headings that are."""
    looks = chain.headings[robot]
    left = [replace(one, arc=in_common(one.arc, [looks])) for one in chain.slices_of(robot) if not are_apart(one.arc, looks)]
    return any(some and are_within(some, slices) for some in (left, chain.around(robot)))
