"""What the robust filter knows at one time, and what happened on the way: rejected, contradictory, put aside, started over."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from filter.arrays import Array, Frozen
from filter.geometry.angles import AngularIntervals
from filter.guarantee import Guarantee
from filter.linear.sources import Source
from filter.records.names import InWords
from filter.robust.cameras import Offsets
from filter.robust.hypotheses import Hypotheses, polygon_of
from filter.robust.trust import Trust
from filter.robust.votes import Votes
from filter.sets.regions import Region
from filter.team import Team


@dataclass(frozen=True)
class Rejected(InWords):
    """A measurement that was dropped, for the others to agree.

    Attributes:
        source: What was dropped.
        conflict: What was proved to exclude one another, the dropped one with it or resting on it.
    """

    source: Source
    conflict: tuple[Source, ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"rejected {words(self.source)}; in conflict: {'; '.join(map(words, self.conflict))}"


@dataclass(frozen=True)
class Disagreement(InWords):
    """Votes on a robot were proved to exclude one another: one of them is wrong. A new window has begun.

    Attributes:
        time: When [s].
        robot: Whose pose the votes are on.
        suspects: The last vote, or odometry if it has led out of the arena, and those without which all others agree.
    """

    time: float
    robot: int
    suspects: tuple[Source, ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"on {words(self.robot)} disagree, one of them is wrong: {'; '.join(map(words, self.suspects))}"


@dataclass(frozen=True)
class Restarted(InWords):
    """A robot starts over from anywhere in the arena: it was lost, or it had believed a sensor that is now put aside.

    Attributes:
        time: When [s].
        robot: Which one.
        suspended_since: The guarantee for it was suspended from then to now [s].
        because: What was rejected, or put aside.
    """

    time: float
    robot: int
    suspended_since: float
    because: str

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"{words(self.robot)} starts over, guarantee suspended since {self.suspended_since:.3f} s: {self.because}"


@dataclass(frozen=True)
class Distrusted:
    """A camera or an identity was put aside, as its sightings are contradicted again and again; or it is trusted again.

    Attributes:
        time: When [s].
        sensor: "camera" or "identity".
        kind: "robot" or "landmark".
        body: Which one, by its number among all bodies.
        aside: True when it is put aside, False when it is trusted again.
        since: Since when its sightings are contradicted, without one that agrees [s]; infinite when it is trusted again.
        pairs: With whom: the bodies that the camera saw, or the robots that read the identity.
    """

    time: float
    sensor: str
    kind: str
    body: int
    aside: bool
    since: float
    pairs: tuple[int, ...]

    def __str__(self) -> str:
        pairs = map(str if self.sensor == "camera" else "robot {}".format, self.pairs)
        return self._in_words(f"{self.kind} {self.body}", pairs)

    def named(self, team: Team) -> str:
        """Return it in words, with the names that a team has for robots and landmarks."""
        return self._in_words(team.name(self.body), map(team.name, self.pairs))

    def _in_words(self, body: str, pairs: Iterable[str]) -> str:
        name = f"{self.sensor} of {body}"
        if not self.aside:
            return f"{name} trusted again at {self.time:.3f} s"
        bodies = ("of " if self.sensor == "camera" else "by ") + ", ".join(pairs)
        return f"{name} put aside at {self.time:.3f} s: sightings {bodies} contradict regions since {self.since:.3f} s"


@dataclass(frozen=True)
class Turned(InWords):
    """A camera is suspected to be turned, as its robot drives in another direction than it shows; or it is trusted again.

    **This is statistical evidence, no proof**: sets do not exclude it. As long as it lasts, the camera's bearings tell where
    the robot is, however far the camera is turned, but not its heading, which can be any; a compass is not merged. The robot
    starts over at first, and when the camera is trusted again.

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
        return f"camera of {robot} suspected to be turned since {self.since:.0f} s: {told}; its heading can be any"


@dataclass(frozen=True)
class Late(InWords):
    """A camera's clock is suspected to be wrong against that of its robot's commands; or it is trusted again.

    **This is statistical evidence, no proof.** As long as it lasts, nothing that the camera says is merged; the robot starts
    over at first. While there is no estimate, as the robot knows too little, the camera is on trial: it is listened to, with
    the guarantee for its robot suspended, until there is one again; then the robot starts over.

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


RobustEvent = Rejected | Disagreement | Restarted | Distrusted | Turned | Late


@dataclass(frozen=True, eq=False)
class RobustBelief(Frozen):
    """What the robust filter knows at one time.

    Attributes:
        time: When [s].
        sets: (n) where each robot can be.
        votes: The votes so far.
        trust: Which sensors are put aside.
        offsets: What is suspected of the cameras; statistical evidence.
        guarantee: Suspended for a robot while it is in doubt, until the doubt is gone or the robot starts over.
        disputed: (n,) when votes on a robot were last rejected, disagreed, or were forgotten [s]; -inf for never.
        events: What happened in the last prediction or update.
    """

    time: float
    sets: tuple[Hypotheses, ...]
    votes: Votes
    trust: Trust
    offsets: Offsets
    guarantee: Guarantee
    disputed: Array
    events: tuple[RobustEvent, ...] = ()

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """(n) where each robot is; nothing is known from inside."""
        return tuple(Region(polygon_of(known.hull()), None, 0, None, ()) for known in self.sets)

    @cached_property
    def headings(self) -> AngularIntervals:
        """(n) arcs that contain the robots' headings; whole circles where a camera is suspected to be turned."""
        suspected = self.offsets.turned.tolist()
        arcs = np.array([(0.0, np.pi) if off else known.heading() for known, off in zip(self.sets, suspected, strict=True)])
        return AngularIntervals(arcs[:, 0], arcs[:, 1])
