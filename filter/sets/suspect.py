"""Who can be wrong where something is proved to be, and what happens on the way from a conflict to a culprit."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Self, cast

import numpy as np

from filter.linear.sources import NOBODY, Source
from filter.records.names import InWords

SuspectKind = Literal["sighting", "compass", "body", "exchange", "sensor", "past"]
Verdict = Literal["guilty", "acquitted", "trusted again"]


@dataclass(frozen=True)
class Suspect(InWords):
    """What can be wrong, by itself, where measurements, motions and what was known exclude one another.

    Attributes:
        kind: The "past" of a robot: where it started, its odometry, its limits; its "compass"; its "sensor", all others that it
            has; a "body" that is not where it should be, whoever sees it; a "sighting": what the robot takes for the target is
            something else; or an "exchange": robot and target wear each other's marker.
        robot: Whose; None for a body.
        target: The body, what is sighted, or the other robot of an exchange; else None.
        since: From when on [s].
    """

    kind: SuspectKind
    robot: int | None = None
    target: int | None = None
    since: float = 0.0

    @classmethod
    def of(cls, who: tuple[str, int, int], since: float) -> Self:
        """Return the suspect of a kind, a robot and a target, -1 for nobody, since a time [s]."""
        robot, target = (None if body == NOBODY else body for body in who[1:])
        return cls(cast("SuspectKind", who[0]), robot, target, since)

    @property
    def who(self) -> tuple[str, int, int]:
        """The suspect without its time, in an order of its own."""
        robot, target = (NOBODY if body is None else body for body in (self.robot, self.target))
        return self.kind, robot, target

    def __str__(self) -> str:
        return self._in_words(lambda body: f"robot {body}" if body == self.robot or self.kind == "exchange" else str(body))

    def _in_words(self, words: Callable[[Any], str]) -> str:
        robot, target = ("" if body is None else words(body) for body in (self.robot, self.target))
        told = {
            "sighting": f"what {robot} takes for {target}",
            "compass": f"compass of {robot}",
            "body": f"place or marker of {target}",
            "exchange": f"markers of {robot} and {target}, exchanged",
            "sensor": f"sensor of {robot}",
            "past": f"odometry or start of {robot}",
        }
        return told[self.kind]


@dataclass(frozen=True)
class Doubted(InWords):
    """Something is proved to be wrong: what is known from now on is what holds whichever of the suspects it is, if it is one.

    Attributes:
        time: When [s].
        since: The suspects may have been wrong from then on [s].
        conflict: What is proved to exclude one another.
        suspects: Who can be wrong.
    """

    time: float
    since: float
    conflict: tuple[Source, ...]
    suspects: tuple[Suspect, ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        one_of = "; ".join(map(words, self.suspects))
        return f"in doubt since {self.since:.3f} s: {one_of}; in conflict: {'; '.join(map(words, self.conflict))}"


@dataclass(frozen=True)
class Tolerated(InWords):
    """It is proved that not all is right, as the filter tolerates: what is known holds in each case that can be.

    Attributes:
        time: When [s].
        since: When these cases began [s].
        cases: Who is wrong, all of one of these together.
    """

    time: float
    since: float
    cases: tuple[tuple[Suspect, ...], ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        told = [" and ".join(map(words, case)) for case in self.cases]
        return f"wrong since {self.since:.3f} s, and tolerated: {'one of ' if len(told) > 1 else ''}{'; '.join(told)}"


@dataclass(frozen=True)
class Judged(InWords):
    """A suspect is found guilty, is acquitted, or is trusted again.

    Attributes:
        time: When [s].
        suspect: Who.
        verdict: Which of these.
        by: By "proof", if only one thing is wrong: every other suspect would leave a contradiction; or by "evidence": all that
            it said since agrees with what else is known, over many instants and some metres, or with a second sensor.
    """

    time: float
    suspect: Suspect
    verdict: Verdict
    by: Literal["proof", "evidence"]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"{self.verdict}, by {self.by}: {words(self.suspect)}"


@dataclass(frozen=True)
class Passed(InWords):
    """The doubt is over, as all who were suspected agree again, by evidence; what is known holds whoever of them it was.

    Attributes:
        time: When [s].
        since: The doubt was since then [s].
        suspects: One of them was wrong.
    """

    time: float
    since: float
    suspects: tuple[Suspect, ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return (
            f"in doubt no longer; wrong for a while since {self.since:.3f} s was one of: {'; '.join(map(words, self.suspects))}"
        )


@dataclass(frozen=True)
class StartsOver(InWords):
    """More than one thing is wrong, or a camera was: robots start over from anywhere in the arena, their guarantee suspended.

    Attributes:
        time: When [s].
        robots: Which.
        conflict: What was in doubt, or else in conflict with one another; nothing if it is for their cameras' sake.
        unheard: Robots of which nothing counts that was measured just then, by them or of them.
    """

    time: float
    robots: tuple[int, ...]
    conflict: tuple[Suspect | Source, ...]
    unheard: tuple[int, ...] = ()

    def because(self, words: Callable[[Any], str]) -> str:
        """Return why, in words."""
        if not self.conflict:
            return "its camera is suspected, by evidence"
        return f"more is wrong than one of: {'; '.join(map(words, self.conflict))}"

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"starting over, guarantee suspended: {', '.join(map(words, self.robots))}; {self.because(words)}"


@dataclass(frozen=True)
class Confirmed(InWords):
    """The guarantee of a robot that has started over is in force again, as all has agreed since.

    Attributes:
        time: When [s].
        robot: Which.
    """

    time: float
    robot: int

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"{words(self.robot)} is where it is said to be: guarantee in force again"


@dataclass(frozen=True)
class Turned(InWords):
    """A camera is suspected to be turned, as its robot drives in another direction than it shows; or it is trusted again.

    **This is statistical evidence, no proof**: sets do not exclude it. As long as it lasts, the camera's bearings are not
    merged, ranges are. The robot starts over at first (`StartsOver`): what it believed since then can be wrong.

    Attributes:
        time: When [s].
        robot: Whose camera.
        aside: True when it is suspected, False when it is trusted again.
        offset: How far it is turned, by estimate; positive where bearings are too large [rad].
        deviation: Of the estimate [rad].
        since: The camera can be turned since then [s]; until a while before, it looked good.
    """

    time: float
    robot: int
    aside: bool
    offset: float
    deviation: float
    since: float

    def _in_words(self, words: Callable[[Any], str]) -> str:
        robot = words(self.robot)
        by = f"by {np.degrees(self.offset):+.0f} +- {np.degrees(self.deviation):.0f} degrees"
        told = f"as {robot} drives, its bearings are off {by} (evidence, no proof)"
        if not self.aside:
            return f"camera of {robot} trusted again at {self.time:.3f} s: {told}"
        return f"camera of {robot} suspected to be turned since {self.since:.0f} s: {told}; no bearing of it is merged"


@dataclass(frozen=True)
class Late(InWords):
    """A camera's clock is suspected to be wrong against that of its robot's commands; or it is trusted again.

    **This is statistical evidence, no proof.** As long as it lasts, no bearing and no range of the robot is merged. The robot
    starts over at first (`StartsOver`).

    Attributes:
        time: When [s]; robot, aside and since are as of a camera that is `Turned`.
        delay: How much later than commands its pictures are stamped, besides what is declared, by estimate [s].
        deviation: Of the estimate [s].
    """

    time: float
    robot: int
    aside: bool
    delay: float
    deviation: float
    since: float

    def _in_words(self, words: Callable[[Any], str]) -> str:
        robot = words(self.robot)
        by = f"{abs(self.delay):.2f} +- {self.deviation:.2f} s too {'late' if self.delay > 0 else 'early'}"
        told = f"as {robot} turns, its pictures are stamped {by} (evidence, no proof)"
        if not self.aside:
            return f"camera of {robot} trusted again at {self.time:.3f} s: {told}"
        return f"camera of {robot} suspected to be late since {self.since:.0f} s: {told}; nothing of it is merged"
