"""Boxes of poses, and what no pose in them can be: interval arithmetic, of which only what is excluded counts.

Every test returns which boxes have a pose left for all that it knows; that may be too many, never too few. It shares nothing
with the filter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter import Array, Mask

ROUNDING = 1e-9  # that all tests allow for [m], [rad]


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes of poses x, y, heading.

    Attributes:
        middle: (k, 3) [m], [m], [rad]; the heading need not be wrapped.
        half: (k, 3) half of their sides.
    """

    middle: Array
    half: Array

    def __len__(self) -> int:
        return len(self.middle)

    @classmethod
    def between(cls, low: Array, high: Array, heading: tuple[float, float]) -> Boxes:
        """Return one box, from corners (2,) and an arc with its middle and half-width."""
        middle, half = (low + high) / 2, (high - low) / 2
        return cls(np.array([[*middle, heading[0]]]), np.array([[*half, min(heading[1], np.pi)]]))

    def select(self, which: Mask) -> Boxes:
        """Return some of them."""
        return Boxes(self.middle[which], self.half[which])

    def split(self, lever: float) -> Boxes:
        """Return their halves, across the longest side; a heading counts as what it moves a body at the end of a lever [m]."""
        longest = np.eye(3, dtype=bool)[np.argmax(self.half * [1.0, 1.0, lever], axis=1)]
        quarter = np.where(longest, self.half / 2, 0.0)
        half = self.half - quarter
        return Boxes(np.concatenate([self.middle - quarter, self.middle + quarter]), np.concatenate([half, half]))

    @property
    def middles(self) -> Boxes:
        """The poses in their middles, as boxes without size."""
        return Boxes(self.middle, np.zeros_like(self.half))

    def away(self, low: Array, high: Array) -> tuple[Array, Array, Array, Array]:
        """Return how bodies in (s, 2) corners are away from them, each (k, s).

        Returns:
            The least and the greatest distance [m], the direction and its largest deviation [rad].
        """
        place, reach = self.middle[:, None, :2], self.half[:, None, :2]
        near, far = low - place - reach, high - place + reach  # of what is between box and body
        least = np.hypot(*np.maximum(0.0, np.maximum(near, -far)).transpose(2, 0, 1))
        greatest = np.hypot(*np.maximum(np.abs(near), np.abs(far)).transpose(2, 0, 1))
        across = (near + far) / 2
        way = np.arctan2(across[..., 1], across[..., 0])
        corners = [np.arctan2(y[..., 1], x[..., 0]) for x in (near, far) for y in (near, far)]
        wide = np.max([np.abs(_wrapped(corner - way)) for corner in corners], axis=0)
        return least, greatest, way, np.where(least > 0, wide, np.pi)

    def within_range(self, bodies: tuple[Array, Array], ranges: Array) -> Mask:
        """Return (k,) which have a pose at (s, 2) least and greatest distances from bodies in corners (s, 2) each."""
        least, greatest, _, _ = self.away(*bodies)
        return _all((least <= ranges[:, 1] + ROUNDING) & (greatest >= ranges[:, 0] - ROUNDING))

    def within_bearing(self, bodies: tuple[Array, Array], bearings: Array) -> Mask:
        """Return (k,) which have a pose that sees bodies in corners (s, 2) each at (s, 2) bearings and their bounds [rad]."""
        _, _, way, wide = self.away(*bodies)
        return _meet(way - self.middle[:, 2:], wide + self.half[:, 2:], bearings)

    def within_direction(self, bodies: tuple[Array, Array], directions: Array) -> Mask:
        """Return (k,) which have a place that bodies in corners (s, 2) each see at (s, 2) directions and their bounds [rad]."""
        _, _, way, wide = self.away(*bodies)
        return _meet(way + np.pi, wide, directions)

    def within_heading(self, headings: Array) -> Mask:
        """Return (k,) which have a heading within all of (c, 2) headings and their bounds [rad]."""
        return _meet(self.middle[:, 2:], self.half[:, 2:], headings)

    def within_supports(self, normals: Array, supports: Array) -> Mask:
        """Return (k,) which have a place no farther along normals (d, 2) than (k, d) supports [m]."""
        nearest = self.middle[:, :2] @ normals.T - self.half[:, :2] @ np.abs(normals).T
        return _all(nearest <= supports + ROUNDING)


def _meet(middle: Array, half: Array, arcs: Array) -> Mask:
    """Return (k,) whether arcs, (k, s) middles and half-widths, all have a direction in common with (s, 2) others."""
    return _all(np.abs(_wrapped(middle - arcs[:, 0])) <= half + arcs[:, 1] + ROUNDING)


def _wrapped(angle: Array) -> Array:
    return np.mod(angle + np.pi, 2 * np.pi) - np.pi


def _all(hold: Mask) -> Mask:
    return np.asarray(hold.all(axis=1))
