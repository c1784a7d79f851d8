"""Where a robot can have come to since it was known where it was, by what was told of its motion."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from experiments.broken.boxes import Boxes
from filter import AngularIntervals, Array, Mask, Odometry, Polygon

SIDES = 24
TURNS = 2 * np.pi * np.arange(SIDES) / SIDES  # of the normals that a region is held by, those of a box among them
NORMALS = np.stack([np.cos(TURNS), np.sin(TURNS)], axis=1)


def _none() -> Array:
    return np.zeros((0, 2))


@dataclass(frozen=True, eq=False)
class Past:
    """What was known of a robot at some time, and what it was told to have done since.

    Attributes:
        supports: (SIDES,) how far its region reached along `NORMALS` [m].
        heading: Middle and half-width of the arc of its heading then [rad].
        chords: (s, 2) least and greatest length of each displacement since [m].
        ways: (s, 2) direction of each, from the heading at its beginning, and its bound [rad].
        turns: (s, 2) how it turned, and the bound [rad].
        slip: How far it slipped altogether [m].
    """

    supports: Array
    heading: tuple[float, float]
    chords: Array = field(default_factory=_none)
    ways: Array = field(default_factory=_none)
    turns: Array = field(default_factory=_none)
    slip: float = 0.0

    @classmethod
    def of(cls, region: Polygon, headings: AngularIntervals, robot: int) -> Past:
        """Return what is known of a robot now: its region, and its arc among those of the team."""
        supports = (NORMALS @ region.vertices.T).max(axis=1) + region.margin
        return cls(supports, (float(headings.centre[robot]), float(headings.bound[robot])))

    def moved(self, told: Odometry, robot: int) -> Past:
        """Return what is known after a motion."""
        (row,) = np.flatnonzero(told.robot == robot)
        turn, off, aside = told.turn[row], told.turn_bound[row], told.direction_bound[row]
        length, error = told.distance[row], told.distance_bound[row]
        straight = np.cos(min(np.pi / 2, (abs(turn) + off) / 2 + aside))  # a path that bends gets less far than it is long
        least, most = length - error, length + error
        chord = least * (straight if least > 0 else 1), most * (straight if most < 0 else 1)
        return replace(
            self,
            chords=np.vstack([self.chords, chord]),
            ways=np.vstack([self.ways, (turn / 2 + told.aside[row], off / 2 + aside)]),
            turns=np.vstack([self.turns, (turn, off)]),
            slip=self.slip + float(told.slip_bound[row]),
        )

    @property
    def heading_now(self) -> tuple[float, float]:
        """Middle and half-width of the arc of its heading [rad]."""
        return self.heading[0] + float(self.turns[:, 0].sum()), self.heading[1] + float(self.turns[:, 1].sum())

    def reach(self, headings: Array) -> Array:
        """Return (k, SIDES) how far along `NORMALS` it can be with headings within (k, 2) middles and half-widths [m].

        Each displacement's direction is that of the heading now, less all turns that came after its heading.
        """
        later = np.cumsum(self.turns[::-1], axis=0)[::-1]  # its own among them, of which half is counted back
        way = headings[:, :1] + self.ways[:, 0] - later[:, 0]
        wide = headings[:, 1:] + self.ways[:, 1] + later[:, 1] - self.turns[:, 1]
        off = np.abs(np.mod(way[:, None] - TURNS[:, None] + np.pi, 2 * np.pi) - np.pi)
        nearest, farthest = np.cos(np.maximum(0.0, off - wide[:, None])), np.cos(np.minimum(np.pi, off + wide[:, None]))
        products = [chord * cosine for chord in self.chords.T for cosine in (nearest, farthest)]
        return self.supports + self.slip + np.max(products, axis=0).sum(axis=2)

    @property
    def box(self) -> Boxes:
        """The box of all poses that it can have."""
        heading = self.heading_now
        reach = self.reach(np.array([heading]))[0]
        quarter = SIDES // 4
        east, north, west, south = reach[::quarter]
        return Boxes.between(np.array([-west, -south]), np.array([east, north]), heading)

    def allows(self, boxes: Boxes) -> Mask:
        """Return (k,) which boxes have a pose that it can have."""
        inside = boxes.within_heading(np.array([self.heading_now]))
        return inside & boxes.within_supports(NORMALS, self.reach(np.stack([boxes.middle[:, 2], boxes.half[:, 2]], axis=1)))
