"""Where an episode takes place, and what is promised in it: drawn once, and fixed from then on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter import Array, InvalidInput, Team

ROBOTS = 3
HALF = 6.0  # of the arena's side [m]
INSIDE = 5.5  # no robot gets farther from either axis [m]
APART = 3.0  # landmarks are at least so far from one another, three or eight a little less [m]
STEP = 1.0  # between two frames [s]
# What odometry, compasses and cameras promise.
DISTANCE, TURN, DIRECTION, SLIP = 0.015, np.radians(1.0), np.radians(1.5), 0.01
COMPASS, BEARING, RANGE = np.radians(2.0), np.radians(2.0), 0.1
HEADING = np.radians(8.0)  # of the headings that are known at the start
SHARE = 1 - 1e-9  # of a bound that an error is at most, as the numbers of a record are rounded
NEAREST = 0.3  # what is nearer is not seen [m]
LANDMARKS = (1, 8)  # the least and the greatest number


@dataclass(frozen=True, eq=False)
class Scene:
    """A team among landmarks, with what its sensors promise.

    Attributes:
        landmarks: (l, 2) places on the map [m].
        view: How far cameras see [m].
        compass: Whether robots have one.
        relative: What errors of ranges may be besides, as a share of them.
        extreme: Whether every error is at its bound, or uniform within it.
        start: Half the side of the boxes in which robots begin [m].
        headings: Whether headings are known at the start.
    """

    landmarks: Array
    view: float
    compass: bool
    relative: float
    extreme: bool
    start: float
    headings: bool

    @classmethod
    def drawn(cls, rng: np.random.Generator, landmarks: int, *, compass: bool) -> Scene:
        """Draw a scene; 4 landmarks and more are all in view, fewer are near the middle, in view now and then.

        Args:
            rng: Where it is drawn from.
            landmarks: How many.
            compass: Whether robots have one for sure.

        Raises:
            InvalidInput: There are too few landmarks, or too many.
        """
        least, most = LANDMARKS
        if not least <= landmarks <= most:
            raise InvalidInput(f"a number of landmarks from {least} to {most}", f"{landmarks!r}")
        rich = landmarks >= 4
        return cls(
            landmarks=_apart(rng, landmarks, INSIDE if rich else HALF / 2),
            view=4 * HALF if rich else float(rng.uniform(4.5, 5.0)),
            compass=bool(rng.random() < 0.5) or compass,
            relative=float(rng.choice([0.0, 0.02])),
            extreme=bool(rng.random() < 0.5),
            start=float(rng.uniform(0.3, 0.5)),
            headings=bool(rng.random() < 0.5),
        )

    @property
    def team(self) -> Team:
        """The robots and the landmarks, as a filter knows them."""
        return Team(ROBOTS, self.landmarks, speed_limit=1.0, turn_rate_limit=1.5, arena=[[-HALF, -HALF], [HALF, HALF]])

    def errors(self, rng: np.random.Generator, *shape: int) -> Array:
        """Draw errors of a shape, as shares of their bounds."""
        if self.extreme:
            return SHARE * rng.choice([-1.0, 1.0], shape)
        return SHARE * rng.uniform(-1, 1, shape)


def _apart(rng: np.random.Generator, count: int, half: float) -> Array:
    """Draw (count, 2) places within a square, no two too near each other."""
    places = [rng.uniform(-half, half, 2)]
    apart = min(APART, 1.45 * half / np.sqrt(count))  # so that there is room for all, wherever the first ones are
    while len(places) < count:
        place = rng.uniform(-half, half, 2)
        if min(np.hypot(*(place - other)) for other in places) >= apart:
            places.append(place)
    return np.array(places)
