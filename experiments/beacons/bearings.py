"""Where bearings to known places leave a robot that knows nothing of its heading, exactly.

Independent of the filter. A place agrees with all bearings if one heading does. Bounds below 60 degrees make this a matter of
pairs: arcs shorter than a third of the circle, of which every two meet, all meet (Helly). And of two bearings
the difference counts, which is the angle at which the robot sees the two places: it is constant along a circle through
both (the inscribed angle). So the border is made of pieces of two circles for each pair.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from experiments.beacons.arcs import Hull, RoundSet, hull_between
from experiments.following.frozen import freeze
from filter import Array, InvalidInput, wrap

ROOM = 1e-9  # by which differences of bearings are made narrower and wider [rad]: far above rounding
FLAT = 1e-10  # an angle that is nearer to 0 or 180 degrees is taken as that far, as its circle would be a line [rad]


@dataclass(frozen=True, eq=False)
class Sights:
    """Bearings to known places from one robot.

    Attributes:
        places: (k, 2) what is seen, at least two, no two at the same place [m].
        bearings: (k,) in the robot's frame [rad].
        bound: Largest error of each, below 60 degrees [rad].
    """

    places: Array
    bearings: Array
    bound: float

    def __post_init__(self) -> None:
        freeze(self)
        if not 0 < self.bound < np.pi / 3 or len(self.bearings) < 2:
            raise InvalidInput(
                "two bearings or more, with a bound below 60 degrees", f"{len(self.bearings)}, {self.bound!r} rad"
            )

    def widened(self, by: float) -> Sights:
        """Return sights that are less certain, so that differences may be off by so much more, or less [rad]."""
        return replace(self, bound=self.bound + by / 2)

    def within(self, box: Array) -> RoundSet:
        """Return the places in a box (2, 2) [m] from which all can be seen so, with one heading."""
        pairs = list(combinations(range(len(self.bearings)), 2))
        circles = [self._circle(i, j, side) for i, j in pairs for side in (-2 * self.bound, 2 * self.bound)]
        return RoundSet(np.array(circles), box, self._excess, ROOM / 10)

    def _circle(self, i: int, j: int, off: float) -> Array:
        """Return the circle from which place i is seen so far left of place j."""
        angle = self.bearings[i] - self.bearings[j] + off
        if abs(np.sin(angle)) < FLAT:
            angle += FLAT
        (x, y), middle = self.places[i] - self.places[j], (self.places[i] + self.places[j]) / 2
        centre = middle + np.array([-y, x]) / (2 * np.tan(angle))
        return np.array([*centre, abs(np.hypot(x, y) / (2 * np.sin(angle)))])

    def _excess(self, points: Array) -> Array:
        apart = self.places - points[:, None]
        turned = np.arctan2(apart[..., 1], apart[..., 0]) - self.bearings
        i, j = np.array(list(combinations(range(len(self.bearings)), 2))).T
        return np.asarray((np.abs(wrap(turned[:, i] - turned[:, j])) - 2 * self.bound).max(axis=1))


def exact_hull_of_sights(sights: Sights, box: Array) -> Hull:
    """Return the hull of the places in a box (2, 2) [m] from which all can be seen so, whatever the heading."""
    return hull_between([sights.widened(-ROOM).within(box)], [sights.widened(ROOM).within(box)])
