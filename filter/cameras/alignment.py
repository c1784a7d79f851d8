"""When a camera is suspected to be turned, or late: what a good one is, and how sure an estimate has to be."""

from dataclasses import dataclass

import numpy as np

from filter.arrays import positive, settle


@dataclass(frozen=True)
class Alignment:
    """When a camera is suspected to be turned, or late. Raises InvalidInput if a value is out of its range.

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
