"""What the robust filter knows at one time, and what happened on the way: rejected, contradictory, put aside, started over."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from filter.angles import AngularIntervals
from filter.arrays import Array, Mask, read_only
from filter.belief import Rejected, Source
from filter.hypotheses import Hypotheses, polygon_of
from filter.region import Region
from filter.trust import Trust
from filter.voting import Votes


@dataclass(frozen=True)
class Disagreement:
    """Votes on a robot were proved to exclude one another: one of them is wrong. A new window has begun.

    Attributes:
        time: When [s].
        robot: Whose pose the votes are on.
        suspects: The last vote, and those without which all others agree.
    """

    time: float
    robot: int
    suspects: tuple[Source, ...]

    def __str__(self) -> str:
        return f"on robot {self.robot} disagree, one of them is wrong: {'; '.join(map(str, self.suspects))}"


@dataclass(frozen=True)
class Restarted:
    """A robot starts over from anywhere in the arena: it was lost, or it had believed a sensor that is now put aside.

    Attributes:
        time: When [s].
        robot: Which one.
        doubtful_since: The guarantee for it was suspended from then to now [s].
        because: What was rejected, or put aside.
    """

    time: float
    robot: int
    doubtful_since: float
    because: str

    def __str__(self) -> str:
        return f"robot {self.robot} starts over, doubtful since {self.doubtful_since:.3f} s: {self.because}"


@dataclass(frozen=True)
class Distrusted:
    """A camera or an identity was put aside, as its sightings are contradicted again and again; or it is trusted again.

    Attributes:
        time: When [s].
        sensor: "camera" or "identity".
        body: Of which robot; an identity can be that of a landmark.
        aside: True when it is put aside, False when it is trusted again.
    """

    time: float
    sensor: str
    body: int
    aside: bool

    def __str__(self) -> str:
        return f"{self.sensor} of body {self.body} {'put aside' if self.aside else 'trusted again'} at {self.time:.3f} s"


RobustEvent = Rejected | Disagreement | Restarted | Distrusted


@dataclass(frozen=True, eq=False)
class RobustBelief:
    """What the robust filter knows at one time.

    Attributes:
        time: When [s].
        sets: (n) where each robot can be.
        votes: The votes so far.
        trust: Which sensors are put aside.
        doubtful_since: (n,) since when the guarantee for a robot is suspended [s]; infinite where it is in force.
        suspended: (n,) when it last was [s]; -inf for never.
        events: What happened in the last update.
    """

    time: float
    sets: tuple[Hypotheses, ...]
    votes: Votes
    trust: Trust
    doubtful_since: Array
    suspended: Array
    events: tuple[RobustEvent, ...] = ()

    def __post_init__(self) -> None:
        for name in ("doubtful_since", "suspended"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def in_force(self) -> Mask:
        """(n,) whether the guarantee is in force for each robot."""
        return np.isinf(self.doubtful_since)

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """(n) where each robot is; nothing is known from inside."""
        return tuple(Region(polygon_of(known.hull()), None, 0, None, ()) for known in self.sets)

    @cached_property
    def headings(self) -> AngularIntervals:
        """(n) arcs that contain the robots' headings."""
        arcs = np.array([known.heading() for known in self.sets])
        return AngularIntervals(arcs[:, 0], arcs[:, 1])
