"""What every filter of sets says of a team, and all that pictures and trajectories need of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from filter import AngularIntervals, Array, GaussianBelief, Guarantee, Mask, Polygon, Region, Regions


class Located(Protocol):
    """A belief that has a region and a heading interval for each robot."""

    @property
    def regions(self) -> Sequence[Region]:
        """(n) where each robot is."""

    @property
    def headings(self) -> AngularIntervals:
        """(n) arcs that contain the headings."""


class Warranted(Located, Protocol):
    """A belief that says for which robots its regions and headings are guaranteed."""

    @property
    def guarantee(self) -> Guarantee:
        """For which robots both are guaranteed, or since when and why they are not."""


def outers(belief: Located) -> Sequence[Polygon]:
    """Return (n) the outer polygons alone: what proves their edges takes as long to look up as all the rest."""
    regions = belief.regions
    return regions.outer if isinstance(regions, Regions) else [region.outer for region in regions]


def there(belief: Located | GaussianBelief) -> Mask:
    """Return (n,) which robots are not away, so that anything is said of them."""
    guarantee, here = getattr(belief, "guarantee", None), np.ones(len(directions(belief)), dtype=bool)
    here[list(guarantee.away if guarantee else ())] = False
    return here


def points(belief: Located | GaussianBelief) -> Array:
    """Return (n, 2) the point for each robot of what any filter knows [m]: the middle of its polygon, or a mean.

    NaN of a robot that is away.
    """
    if isinstance(belief, GaussianBelief):
        middles = belief.mean[:, :2]
    else:
        middles = np.array([outer.centroid for outer in outers(belief)])
    return np.where(there(belief)[:, None], middles, np.nan)


def directions(belief: Located | GaussianBelief) -> Array:
    """Return (n,) the heading for each robot of what any filter knows [rad]: the middle of its interval, or a mean."""
    if isinstance(belief, GaussianBelief):
        return np.asarray(belief.mean[:, 2])
    return np.asarray(belief.headings.centre)


def inside(belief: Located, positions: Array) -> Mask:
    """Return (n,) whether each outer polygon contains its own of (n, 2) positions [m]; none one that is not finite."""
    if isinstance(belief.regions, Regions):
        return belief.regions.contains(positions)
    return np.array([outer.contains(place) for outer, place in zip(outers(belief), positions, strict=True)], dtype=bool)
