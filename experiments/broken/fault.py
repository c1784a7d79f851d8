"""Eight ways in which a bound is broken, and how each is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from filter import InvalidInput

Kind = Literal["slip", "kidnap", "start", "compass", "swap", "misread", "biased", "moved"]
KINDS: tuple[Kind, ...] = get_args(Kind)
LASTING = ("swap", "biased", "moved")
# What is lied about: two places change their names, so that it is as large as they are far from each other.
OF_NAMES = ("swap", "misread")
# What passes and leaves nothing behind: past and map are right.
OF_INSTANTS = ("compass", "misread")
LARGE, TURNED = 0.5, np.radians(15)  # what is beyond either is large [m], [rad]
SMALL, HARDLY = 0.05, np.radians(1.5)  # what is below both is no less: some of it no sensor can tell from its errors
SHARE_BELOW = 0.2  # of episodes with a small fault


@dataclass(frozen=True)
class Fault:
    """What breaks a bound in one episode.

    Attributes:
        kind: One of `KINDS`.
        when: Number of the first frame in which something is wrong; what is told of the motion to a frame belongs to it.
        until: Number of the first frame in which every bound holds again; infinite for a fault that lasts.
        below: Whether it is below `LARGE` and `TURNED`.
        robot: Whose wheels, past, compass, camera or reading; of two that are exchanged the first; -1 for a landmark.
        body: Who is exchanged with the robot, read wrongly, or moved; -1 where nobody is.
        read: As whom it is read; -1 where nothing is.
        offset: By how much in x and y: carried, put, moved. Of a slip and of ranges it is x alone [m].
        turn: By how much headings or bearings are off [rad].
    """

    kind: Kind
    when: int
    until: float
    below: bool
    robot: int = -1
    body: int = -1
    read: int = -1
    offset: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0

    def now(self, kind: Kind, frame: int) -> bool:
        """Return whether it is of this kind, and there in a frame of this number."""
        return self.kind == kind and self.when <= frame < self.until

    def begins(self, kind: Kind, frame: int) -> bool:
        """Return whether it is of this kind and begins in a frame of this number."""
        return self.kind == kind and frame == self.when

    @property
    def lasts(self) -> bool:
        """Whether it never ends."""
        return bool(np.isinf(self.until))

    @property
    def settled(self) -> int:
        """Number of the first good frame, from which on a filter has to get right: what lasts is to be found out."""
        return self.when if self.lasts else int(self.until)

    @property
    def guilty(self) -> tuple[str, tuple[int, ...]]:
        """The culprit: of what kind, and which bodies."""
        if self.kind == "swap":
            return "exchange", tuple(sorted((self.robot, self.body)))
        if self.kind == "misread":
            return "sighting", (self.robot, self.read)
        if self.kind == "moved":
            return "body", (self.body,)
        return {"compass": "compass", "biased": "sensor"}.get(self.kind, "past"), (self.robot,)


def checked_kind(kind: str) -> Kind:
    """Return a kind; raises `InvalidInput` if there is no such one."""
    for known in KINDS:
        if kind == known:
            return known
    raise InvalidInput(f"kinds of faults among {', '.join(KINDS)}", repr(kind))


def size_drawn(rng: np.random.Generator, most: tuple[float, float], *, below: bool) -> tuple[float, float]:
    """Draw how large a fault is, with its signs: small in both ways, or large in both or either.

    Args:
        rng: Where it is drawn from.
        most: Its greatest size [m], [rad]; 0 where it has none of the kind.
        below: Whether it is small.

    Returns:
        Metres and radians; 0 where it is not of the kind.
    """
    can = np.array(most) > 0
    does = can & (rng.random(2) < 0.7)
    if not does.any():
        does[rng.choice(np.flatnonzero(can))] = True
    low, high = ([SMALL, HARDLY], [LARGE, TURNED]) if below else ([LARGE, TURNED], np.maximum(most, [LARGE, TURNED]))
    metres, radians = rng.uniform(low, high) * rng.choice([-1.0, 1.0], 2) * does
    return float(metres), float(radians)
