"""The filter's own checks of numbers and columns, which logs share: what they refuse is refused here, in the same words."""

from filter.arrays import LARGEST, finite, read_only
from filter.records.odometry import SHORTEST
from filter.records.radians import TWO_TURNS, bearing_in_radians, heading_in_radians
from filter.records.record import AT_THE_CENTRE, called, field_names

__all__ = [
    "AT_THE_CENTRE",
    "LARGEST",
    "SHORTEST",
    "TWO_TURNS",
    "bearing_in_radians",
    "called",
    "field_names",
    "finite",
    "heading_in_radians",
    "read_only",
]
