"""What is known in each of several cases, side by side, one of which holds; and what is said of all. Standard library only.

An alternative has a name, a list of what may be wrong in it, one of these, and a chain of its own: from that of its parent, or
from what was known before the first instant at which something may have been wrong. What of each frame counts then is for this
checker to say (`experiments.proof.alternatives.wrong`). It ends where it is proved to be empty; until then it has its part in
the cover.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce

from experiments.proof.alternatives.cover import Cover, covered
from experiments.proof.alternatives.wrong import (
    NOBODY,
    Wrong,
    anywhere,
    apart,
    everybody,
    without,
    without_both,
    words,
    wrong_in,
)
from experiments.proof.chain import Chain, Placed
from experiments.proof.given.frame import Frame
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken, Record, body, exact, located
from experiments.proof.share import Share

AGAIN = "on trust: suspects that are taken to be right again, by evidence"
IN_FORCE = "on trust: robots that are taken to be in force again, by evidence"
WAITING = "on trust: regions of robots that have started over, with the guarantee suspended"
INSTANTS, IS_AGAIN, UNITES, ASIDE = "instants", "again", "unites", "aside"  # what the kinds of records have
OVER, CONFIRMED = "over", "confirmed"  # likewise


@dataclass(frozen=True)
class Alternative:
    """A case.

    Attributes:
        parent: From which it came, "" for what was known before.
        chain: What is proved of it.
        wrong: One of these is wrong.
        is_over: Whether it was, and is right again.
    """

    parent: str
    chain: Chain
    wrong: frozenset[Wrong]
    is_over: bool = False


class Doubts:
    """Checks one step after the other, in doubt or not.

    Attributes:
        assumed: In words what the rest follows from, besides the bounds, and how many suspects there are.
        main: What is proved where nothing is in doubt.
        waiting: Robots that have started over and are not in force again: nothing that ties them to others counts.
    """

    def __init__(self, log: Log, share: Share | None = None, *, is_voted: bool = False) -> None:
        """Take what was given to the filter, whose share it is, and whether sightings are votes; then there are no doubts."""
        self.assumed: Counter[str] = Counter()
        self._share = share or Share()
        self.main, self.waiting = Chain(log, self._share, is_voted=is_voted), frozenset[int]()
        self._log, self._heard, self._aside = log, list[Frame](), list[Wrong]()
        self._living = dict[str, Alternative]()

    @property
    def links(self) -> Counter[str]:
        """How many links of each kind were proved in this process's share."""
        return self.main.links

    def on_trust(self) -> Counter[str]:
        """Return in words what the rest follows from, besides the bounds, and how many suspects or windows there are."""
        windows = self.main.windows
        return self.assumed + Counter({f"on trust: {windows}": windows.count})

    def check(self, headings: Sequence[Placed], lines: Sequence[Placed], told: Sequence[Placed]) -> Cover:
        """Check the next step, with what is told of alternatives; return what is said, which holds in each of them.

        Raises:
            Broken: Something does not follow, or an alternative is missing.
        """
        frame = self._begin(told)
        if told and self.main.is_voted:
            raise Broken(f"a doubt at t = {frame.time} s, where there are votes")
        if self._living or any(INSTANTS in record for _, record in told):
            with located(f"in doubt at t = {frame.time} s"):
                self._go_on(told)
                cover = covered(headings, lines, self._chains(self._living.values()), is_mine=self._share.has_next())
        else:
            self.main.check(headings, lines, frame)
            if self.main.is_empty:
                raise Broken(f"a contradiction at t = {frame.time} s, where nothing is said to be in doubt")
            cover = Cover(self.main.headings, self.main.shown)
        for place, record in told:
            with located(place):
                if ASIDE in record:
                    self._put_aside(record)
                elif CONFIRMED in record:
                    self._confirm({body(robot, self._log.robots) for robot in record[CONFIRMED]})
        self.assumed += Counter({WAITING: len(self.waiting - frame.away)})
        return cover

    def _begin(self, told: Sequence[Placed]) -> Frame:
        """Return what counts of the next frame; robots that are told to start over do so."""
        frame, over = reduce(without, self._aside, self._log.frames[len(self._heard)]), False
        for place, record in told:
            if OVER in record:
                with located(place):
                    frame, over = self._start_over(frame, record), True
        if not over:
            is_in_doubt = self._living or any(INSTANTS in record for _, record in told)
            frame = apart(frame, self.waiting, self._log.robots, self.waiting if is_in_doubt else ())
        self._heard.append(frame)
        return frame

    def _start_over(self, frame: Frame, record: Record) -> Frame:
        """Return what counts of a frame at which robots are anywhere; a doubt ends in what was said before it."""
        robots, unheard = ({body(robot, self._log.robots) for robot in record[each]} - frame.away for each in (OVER, "unheard"))
        if not robots:
            raise Broken("nobody starts over")
        if self._living:
            self.main, self._living = self._together(record, list(self._living.values())), {}
        self.waiting |= robots
        who = ", ".join(self._log.names[robot] for robot in sorted(robots))
        self.assumed[f"on trust: what is wrong at t = {frame.time} s is of none but those who start over: {who}"] += len(robots)
        return anywhere(self._log, apart(frame, self.waiting, self._log.robots, unheard), robots)

    def _confirm(self, robots: set[int]) -> None:
        """Take in that robots that have started over are in force again."""
        if not robots <= self.waiting:
            raise Broken("somebody is in force again who has not started over")
        self.waiting -= robots
        self.assumed[IN_FORCE] += len(robots)

    def _go_on(self, told: Sequence[Placed]) -> None:
        """Check all alternatives of a step, and that none is missing."""
        found, first = dict[str, Alternative](), self._first(told)
        for place, record in told:
            if INSTANTS in record:
                with located(place):
                    if record["name"] in found:
                        raise Broken(f"a second alternative {record['name']}")
                    found[record["name"]] = self._tried(record, first)
        if self._living:
            self._look_for_children(found.values())
        else:
            self._look_for_everybody(found.values(), first)
        self._living = {name: each for name, each in found.items() if not each.chain.is_empty}
        for place, record in told:
            with located(place):
                if IS_AGAIN in record:
                    self._listen_to(record)
                elif UNITES in record:
                    self._unite(record)
        if not self._living:
            raise Broken("no alternative is left: more than one thing is wrong")

    def _first(self, told: Sequence[Placed]) -> int:
        """Return the number of the first frame that alternatives of this step are about."""
        now = len(self._heard) - 1
        if self._living:
            return now
        times = {float(exact(record[INSTANTS][0]["t"])) for _, record in told if INSTANTS in record}
        numbers = [number for number, frame in enumerate(self._heard) if frame.time in times]
        if len(times) != 1 or not numbers:
            raise Broken("alternatives from one frame on were expected")
        return numbers[0]

    def _tried(self, record: Record, first: int) -> Alternative:
        """Check an alternative's steps from a frame up to this one, or up to where it is empty."""
        wrong, is_born = frozenset(wrong_in(self._log, each) for each in record["wrong"]), not self._living
        parent = Alternative("", self.main, wrong) if is_born else self._living[record["parent"]]
        if not wrong or not wrong <= parent.wrong or (parent.is_over and wrong != parent.wrong):
            raise Broken("an alternative in which something else is wrong than in the one before")
        chain = parent.chain.branch(first)
        for number, instant in enumerate(record[INSTANTS], first):
            frame, *others = (self._left(number, each, instant, is_born, parent.is_over) for each in sorted(wrong))
            if any(other != frame for other in others):
                raise Broken("what may be wrong in an alternative leaves out different readings")
            own, lines = ([(name, one) for one in instant[name]] for name in ("headings", "lines"))
            chain.check(own, lines, frame)
            if chain.is_empty:
                break
        if chain.frames < len(self._heard) and not chain.is_empty:
            raise Broken("an alternative that ends before it is proved to be empty")
        return Alternative(record["parent"], chain, wrong, parent.is_over)

    def _left(self, number: int, wrong: Wrong, instant: Record, is_born: bool, is_over: bool) -> Frame:
        """Return what counts of a frame if one thing is wrong, or was."""
        frame, is_now = self._heard[number], number == len(self._heard) - 1
        lost = {body(robot, self._log.robots) for robot in instant["anew"]} - frame.away
        if wrong[0] == "past" and is_born:
            lost.add(wrong[1])
        if not is_over:
            frame = without(frame, wrong) if is_now or wrong[0] != "exchange" else without_both(frame, wrong)
        return anywhere(self._log, frame, lost)

    def _look_for_children(self, found: Collection[Alternative]) -> None:
        for name, before in self._living.items():
            left = before.wrong - {one for each in found if each.parent == name for one in each.wrong}
            if left:
                raise Broken(f"alternative {name} ends without a proof; in it may be wrong: {self._words(left)}")

    def _look_for_everybody(self, found: Collection[Alternative], first: int) -> None:
        """Raise `Broken` if somebody can be wrong, since a frame, of whom there is no alternative.

        A sighting says less than its sensor and its body: where one of these cannot be, it cannot.
        """
        tried = {one for each in found for one in each.wrong}
        gone = {one for each in found if each.chain.is_empty for one in each.wrong}
        for kind, robot, target in sorted(everybody(self._heard[first:], self._log.robots) - tried):
            if kind != "sighting" or not gone & {("sensor", robot, NOBODY), ("body", NOBODY, target)}:
                raise Broken(f"nobody has looked whether this is wrong: {self._words([(kind, robot, target)])}")
        since, now = (self._heard[first - 1].time if first else self._log.start), self._heard[-1].time
        self.assumed[f"on trust: one thing alone was wrong from t = {since} s to {now} s, one of:"] += len(tried)

    def _listen_to(self, record: Record) -> None:
        """Take in that what may have been wrong in an alternative is right again: what is known there holds, all is heard."""
        wrong, name = frozenset(wrong_in(self._log, each) for each in record["wrong"]), record[IS_AGAIN]
        before = self._living[name]
        if not wrong or not wrong <= before.wrong or before.is_over:
            raise Broken("something else is right again than what may be wrong in an alternative")
        chain, own, lines = before.chain, *([("", one) for one in record[each]] for each in ("headings", "lines"))
        if own or lines:
            chain = chain.again(self._heard[-1])
            chain.go_on(own, lines)
        self.assumed[AGAIN] += len(wrong)
        left = self._living.pop(name).wrong - wrong
        self._living |= {name: replace(before, wrong=left)} if left else {}
        if not chain.is_empty:
            self._add(record, Alternative("", chain, wrong, is_over=True))

    def _unite(self, record: Record) -> None:
        """Take in that alternatives are one: what is said of it holds in each, also without what may be wrong still in one."""
        some = [self._living.pop(name) for name in record[UNITES]]
        going_on = [each for each in some if not each.is_over]
        if not some or len(going_on) > 1:
            raise Broken("alternatives are united that are not over")
        wrong = (each.wrong for each in going_on or some)
        self._add(record, Alternative("", self._together(record, some), frozenset().union(*wrong), is_over=not going_on))

    def _together(self, record: Record, some: Sequence[Alternative]) -> Chain:
        """Return what goes on from some alternatives, of what is said in a record and nothing else, as that holds in each."""
        own, lines = ([("", one) for one in record[each]] for each in ("headings", "lines"))
        cover = covered(own, lines, self._chains(some), is_mine=self._share.has_next())
        return some[0].chain.begun(cover.headings, cover.shown)

    def _chains(self, some: Iterable[Alternative]) -> list[Chain]:
        return [each.chain for each in some]

    def _add(self, record: Record, each: Alternative) -> None:
        if record["name"] in self._living:
            raise Broken(f"a second alternative {record['name']}")
        self._living[record["name"]] = each

    def _put_aside(self, record: Record) -> None:
        """Take in who is not listened to from now on, and which alternative was left, if this is the end of a doubt."""
        aside, found = [wrong_in(self._log, each) for each in record[ASIDE]], frozenset[Wrong]()
        if len(self._living) > 1:
            raise Broken("a doubt that is said to be over, where several alternatives are left")
        for last in self._living.values():
            self.main, self._living, found = last.chain, {}, frozenset() if last.is_over else last.wrong
        sightings = [each for each in found if each[0] == "sighting"]
        behind = {("sensor", robot, NOBODY) for _, robot, _ in sightings} | {("body", NOBODY, body) for *_, body in sightings}
        if not set(aside) - set(self._aside) <= found | behind:
            raise Broken("somebody is put aside who was not found to be wrong")
        if any(kind != "past" for kind, *_ in found) and not set(aside) & (found | behind):
            raise Broken("who was found to be wrong is not put aside")
        if not found and set(self._aside) - set(aside):
            self.assumed[AGAIN] += len(set(self._aside) - set(aside))
        self._aside = aside
        if aside:
            since = f"from t = {self._heard[-1].time} s on"
            self.assumed[f"on trust: {since} nothing is wrong but: {self._words(aside)}"] += len(aside)

    def _words(self, some: Collection[Wrong]) -> str:
        return ", ".join(words(self._log, each) for each in sorted(some))
