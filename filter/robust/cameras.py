"""When a camera is suspected to be turned or late, and what is known of that: statistical evidence, no proof."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Frozen, Mask, positive, settle


@dataclass(frozen=True)
class Alignment:
    """When a camera is suspected to be turned, or late.

    Attributes:
        share: The offset of a good camera is at most this share of a bearing's bound, as other errors come on top; in (0, 1].
        deviations: One whose estimate is beyond that by so many of its deviations is suspected, ...
        patience: ... after it has been for so long [s].
        tolerated_delay: So much later than commands, or earlier, a good camera's pictures may be stamped than is declared [s].
        bearing: Deviation of a bearing over its bound.
        range: Deviation of a range over its bound; errors repeat themselves, so it is large.
        lasting: Errors of motion are as large as their bounds, and last so long [s].
        gate: A sighting farther off than so many deviations has the less weight.
        prior: Deviation of an offset of which nothing is known [rad].
        wander: How much an offset may change in a second, by its deviation [rad].
        clock: Deviation of a camera's delay of which nothing is known [s].
        drift: How much a delay may change in a second, by its deviation [s].
        hidden: So long after it is turned or late a camera can still look good [s].

    Raises:
        InvalidInput: A value is out of its range.
    """

    share: float = 0.6
    deviations: float = 2.0
    patience: float = 5.0
    tolerated_delay: float = 0.2
    bearing: float = 0.4
    range: float = 1.5
    lasting: float = 1.0
    gate: float = 3.0
    prior: float = 0.17
    wander: float = 0.0067
    clock: float = 0.2
    drift: float = 0.003
    hidden: float = 60.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            settle(self, **{name: positive(name, value, 1 if name == "share" else np.inf)})


@dataclass(frozen=True, eq=False)
class Offsets(Frozen):
    """What motion says of n cameras.

    Attributes:
        mean: (n, 5) position [m], heading, the camera's offset, positive where bearings are too large [rad], and its delay [s].
        covariance: (n, 5, 5) of it.
        rate: (n,) how fast the robot turned lately [rad/s].
        running: (n,) whether there is an estimate.
        misfit: (n,) the share of the last sightings, some twenty, that are beyond the gate.
        astray: (n, 2) how many landmarks in turn are beyond the gate to one side, negative to the right, and the last.
        allowed: (n,) the bound of the robot's last bearing [rad].
        good_until: (n, 2) until when the camera looked good [s], less the time for which it can hide that it is turned or late.
        bad_since: (n, 2) since when the estimate is that of a turned or late camera [s]; infinite where it is not.
        suspected: (n, 2) cameras that are suspected to be turned, or late.
    """

    mean: Array
    covariance: Array
    rate: Array
    running: Mask
    misfit: Array
    astray: Array
    allowed: Array
    good_until: Array
    bad_since: Array
    suspected: Mask

    @classmethod
    def none(cls, robots: int, time: float) -> Offsets:
        """Return that nothing is known, at a time [s]."""
        nobody, never, zeros = np.zeros((robots, 2), dtype=bool), np.full((robots, 2), np.inf), np.zeros((robots, 5, 5))
        estimate = zeros[:, 0], zeros, zeros[:, 0, 0], nobody[:, 0], zeros[:, 0, 0], zeros[:, 0, :2]
        return cls(*estimate, never[:, 0], np.full((robots, 2), time), never, nobody)

    @property
    def offset(self) -> Array:
        """(n,) estimated offsets of the cameras, positive where bearings are too large [rad]."""
        return self.mean[:, 3]

    @property
    def delay(self) -> Array:
        """(n,) estimated delays of the cameras, positive where they are later than the commands [s]."""
        return self.mean[:, 4]

    @property
    def turned(self) -> Mask:
        """(n,) cameras that are suspected to be turned: their bearings are not to tell a heading."""
        return self.suspected[:, 0]

    @property
    def late(self) -> Mask:
        """(n,) cameras that are suspected to be late: they are not to be believed at all."""
        return self.suspected[:, 1]

    @property
    def on_trial(self) -> Mask:
        """(n,) late cameras without an estimate: they are listened to, with no guarantee, until there is one again."""
        return self.late & ~self.running

    @property
    def deviations(self) -> Array:
        """(n, 2) deviations of offset [rad] and delay [s]."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2)[:, 3:])
