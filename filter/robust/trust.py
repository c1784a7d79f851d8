"""Which sensor is guilty: cameras and identities that are contradicted again and again are put aside until they agree.

A wrong vote here and there is what voting is for. A camera that is turned, or a robot that wears another's barcode, is wrong
all the time. Each sighting has two suspects: the camera that took it and the identity that it names. The one with the larger
share of contradicted sightings is put aside; what it says is then judged but not merged.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from filter.arrays import Array, Frozen, Mask, checked, positive


@dataclass(frozen=True)
class Suspicion(Frozen):
    """When a sensor is put aside. InvalidInput if a value is out of its range.

    Attributes:
        memory: Sightings count less with their age, by 1/e in this time [s].
        repeat: A sighting of a pair that was seen less long ago than this counts by that share only [s].
        strikes: So many contradicted sightings, of a camera at so many instants, and ...
        share: ... this share of all make a sensor be put aside; in (0, 1).
        mercy: Below so many, and below half the share, it is trusted again.
    """

    memory: float = field(default=30.0, metadata=checked(positive, "memory"))
    repeat: float = field(default=1.5, metadata=checked(positive, "repeat"))
    strikes: float = field(default=3.0, metadata=checked(positive, "strikes"))
    share: float = field(default=0.4, metadata=checked(positive, "share", np.nextafter(1, 0)))
    mercy: float = field(default=1.0, metadata=checked(positive, "mercy"))


@dataclass(frozen=True, eq=False)
class Trust(Frozen):
    """The record of every pair of n cameras and b bodies, and which sensors are put aside.

    Attributes:
        time: When [s].
        last: (n, b) when each camera last saw each body [s], -inf for never.
        seen: (n, b) sightings, by weight.
        struck: (n, b) those that were contradicted, by weight.
        streak: (n, b) those since the last that agreed, by weight.
        instants: (n,) at how many instants each camera was contradicted, fading: one bad picture is one, whatever is in it.
        since: (n, b) when the first was contradicted after the last that agreed [s], inf where the last one agreed.
        camera: (n,) cameras that are put aside.
        identity: (b,) bodies whose identity is.
    """

    time: float
    last: Array
    seen: Array
    struck: Array
    streak: Array
    instants: Array
    since: Array
    camera: Mask
    identity: Mask

    @classmethod
    def full(cls, robots: int, bodies: int, time: float) -> Trust:
        """Return full trust: nothing was seen yet."""
        never, none = np.full((robots, bodies), -np.inf), np.zeros((robots, bodies))
        aside = np.zeros(robots, dtype=bool), np.zeros(bodies, dtype=bool)
        return cls(time, never, none, none, none, np.zeros(robots), -never, *aside)

    def aside(self, robot: int, target: int) -> bool:
        """Return whether sightings of this pair are not to be merged."""
        return bool(self.camera[robot] or self.identity[target])

    def judged(self, time: float, sightings: list[tuple[int, int, bool]], rules: Suspicion) -> Trust:
        """Return the trust after sightings at one time: robot, target, and whether it was contradicted."""
        fade = np.exp(-(time - self.time) / rules.memory)
        seen, struck, streak = self.seen * fade, self.struck * fade, self.streak * fade
        last, since, instants = self.last.copy(), self.since.copy(), self.instants * fade
        instants[list({robot for robot, _, contradicted in sightings if contradicted})] += 1
        for robot, target, contradicted in sightings:
            weight = min(1.0, (time - last[robot, target]) / rules.repeat)
            last[robot, target] = time
            seen[robot, target] += weight
            struck[robot, target] += weight * contradicted
            streak[robot, target] = streak[robot, target] + weight if contradicted else 0.0
            since[robot, target] = min(since[robot, target], time) if contradicted else np.inf
        return Trust(time, last, seen, struck, streak, instants, since, self.camera, self.identity)._put_aside(rules)

    def _put_aside(self, rules: Suspicion) -> Trust:
        """Return the trust in which those sensors are trusted again that agree; then the guiltiest are put aside.

        Barcodes are exchanged from one moment to the next, so that an identity is judged by what was seen lately: since it was
        first contradicted without agreeing again. A camera is not, as a robot that is lost contradicts everything at once.
        """
        lately = np.where(self.streak > 0, self.streak, self.seen * (self.last > self.since.min(axis=0)))
        camera, identity = (
            aside & ((self.struck.sum(axis) >= rules.mercy) | (self.struck.sum(axis) >= rules.share / 2 * self.seen.sum(axis)))
            for aside, axis in ((self.camera, 1), (self.identity, 0))
        )
        while True:
            # What is laid to the charge of one that is put aside does not count against the other.
            counts = ~(camera[:, None] | identity)
            cameras = _charges(self.seen * counts, self.struck * counts, 1, rules) * (self.instants > rules.strikes - 1)
            identities = _charges(lately * counts, self.streak * counts, 0, rules)
            if not (cameras.any() or identities.any()):
                return replace(self, camera=camera, identity=identity)
            guilty, shares = (camera, cameras) if cameras.max() > identities.max() else (identity, identities)
            guilty[np.argmax(shares)] = True

    def charges(self, sensor: str, body: int) -> tuple[float, tuple[int, ...]]:
        """Return since when a "camera" or an "identity" is contradicted [s], and the other ends of the pairs that say so."""
        since = self.since[body] if sensor == "camera" else self.since[:, body]
        return float(since.min()), tuple(np.flatnonzero(np.isfinite(since)).tolist())


def _charges(seen: Array, struck: Array, axis: int, rules: Suspicion) -> Array:
    """Return with which share of its sightings each sensor is charged, 0 where that is not enough for it to be put aside."""
    strikes = struck.sum(axis=axis)
    share = strikes / np.maximum(seen.sum(axis=axis), 1e-300)
    return np.where((strikes >= rules.strikes) & (share >= rules.share), share, 0.0)
