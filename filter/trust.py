"""Which sensor is guilty: cameras and identities that are contradicted again and again are put aside until they agree.

A wrong vote here and there is what voting is for (`filter.voting`). A camera that is turned, or a robot that wears another's
barcode, is wrong all the time. Each sighting has two suspects: the camera that took it and the identity that it names. The one
with the larger share of contradicted sightings is put aside; what it says is then judged but not merged.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from filter.arrays import Array, Mask, number, read_only
from filter.errors import InvalidInput


@dataclass(frozen=True)
class Suspicion:
    """When a sensor is put aside.

    Attributes:
        memory: Sightings count less with their age, by 1/e in this time [s].
        repeat: A sighting of a pair that was seen less long ago than this counts by that share only [s].
        strikes: So many contradicted sightings, and ...
        share: ... this share of all make a sensor be put aside; in (0, 1).
        mercy: Below so many, and below half the share, it is trusted again.

    Raises:
        InvalidInput: A value is out of its range.
    """

    memory: float = 30.0
    repeat: float = 1.5
    strikes: float = 3.0
    share: float = 0.4
    mercy: float = 1.0

    def __post_init__(self) -> None:
        for name in ("memory", "repeat", "strikes", "mercy"):
            if number(name, getattr(self, name), 0) == 0:
                raise InvalidInput(f"{name}: above 0", 0)
        number("share", self.share, 0, 1)


@dataclass(frozen=True, eq=False)
class Trust:
    """The record of every pair of n cameras and b bodies, and which sensors are put aside.

    Attributes:
        time: When [s].
        last: (n, b) when each camera last saw each body [s], -inf for never.
        seen: (n, b) sightings, by weight.
        struck: (n, b) those that were contradicted, by weight.
        camera: (n,) cameras that are put aside.
        identity: (b,) bodies whose identity is.
    """

    time: float
    last: Array
    seen: Array
    struck: Array
    camera: Mask
    identity: Mask

    def __post_init__(self) -> None:
        for column in fields(self):
            if column.name != "time":
                object.__setattr__(self, column.name, read_only(getattr(self, column.name)))

    @classmethod
    def full(cls, robots: int, bodies: int, time: float) -> Trust:
        """Return full trust: nothing was seen yet."""
        never, none = np.full((robots, bodies), -np.inf), np.zeros((robots, bodies))
        return cls(time, never, none, none.copy(), np.zeros(robots, dtype=bool), np.zeros(bodies, dtype=bool))

    def aside(self, robot: int, target: int) -> bool:
        """Return whether sightings of this pair are not to be merged."""
        return bool(self.camera[robot] or self.identity[target])

    def judged(self, time: float, sightings: list[tuple[int, int, bool]], rules: Suspicion) -> Trust:
        """Return the trust after sightings at one time: robot, target, and whether it was contradicted."""
        fade = np.exp(-(time - self.time) / rules.memory)
        last, seen, struck = self.last.copy(), self.seen * fade, self.struck * fade
        for robot, target, contradicted in sightings:
            weight = min(1.0, (time - last[robot, target]) / rules.repeat)
            last[robot, target] = time
            seen[robot, target] += weight
            struck[robot, target] += weight * contradicted
        camera, identity = _guilty(seen, struck, self.camera, self.identity, rules)
        return Trust(time, last, seen, struck, camera, identity)


def _guilty(seen: Array, struck: Array, camera: Mask, identity: Mask, rules: Suspicion) -> tuple[Mask, Mask]:
    """Return which sensors are put aside from now on: first those are trusted again that agree, then the guiltiest go."""
    camera, identity = (
        sensors & ((struck.sum(axis) >= rules.mercy) | (struck.sum(axis) >= rules.share / 2 * seen.sum(axis)))
        for sensors, axis in ((camera, 1), (identity, 0))
    )
    while True:
        # What is laid to the charge of one that is put aside does not count against the other.
        counts = ~(camera[:, None] | identity)
        cameras, cameras_share = _charges(seen * counts, struck * counts, 1, rules)
        identities, identities_share = _charges(seen * counts, struck * counts, 0, rules)
        if not (cameras.any() or identities.any()):
            return camera, identity
        if cameras_share.max() > identities_share.max():
            camera[int(np.argmax(cameras_share))] = True
        else:
            identity[int(np.argmax(identities_share))] = True


def _charges(seen: Array, struck: Array, axis: int, rules: Suspicion) -> tuple[Mask, Array]:
    """Return who is charged with enough to be put aside, and with which share of its sightings (0 for those that are not)."""
    strikes, all_ = struck.sum(axis=axis), seen.sum(axis=axis)
    share = strikes / np.maximum(all_, 1e-300)
    charged = (strikes >= rules.strikes) & (share >= rules.share)
    return charged, np.where(charged, share, 0.0)
