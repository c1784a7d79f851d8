"""What every filter of sets says of a team, and all that pictures and trajectories need of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from filter import AngularIntervals, Region


class Located(Protocol):
    """A belief that has a region and a heading interval for each robot."""

    @property
    def regions(self) -> Sequence[Region]:
        """(n) where each robot is."""

    @property
    def headings(self) -> AngularIntervals:
        """(n) arcs that contain the headings."""
