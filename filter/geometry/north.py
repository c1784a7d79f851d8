"""What counts from north: compasses turn clockwise from it, and maps may say north before east.

Here x points east and y to true north, and angles turn counter-clockwise from x.
"""

import numpy as np

from filter.arrays import Array, Floats, finite
from filter.errors import InvalidInput
from filter.geometry.angles import wrap


def heading_from_north(angle: Floats, declination: Floats = 0.0) -> Array:
    """Return headings in (-pi, pi], counter-clockwise from east, of angles clockwise from north, any shape [rad].

    The declination is how far the north that they count from, the magnetic one, say, is east of true north [rad]. Raises
    `InvalidInput` if a value is no finite number, or the two do not go together.
    """
    north, east = finite("angle from north [rad]", angle), finite("declination [rad]", declination)
    try:
        return wrap(np.pi / 2 - (north + east))
    except ValueError:
        raise InvalidInput("one declination, or columns of one length", f"shapes {north.shape} and {east.shape}") from None


def place_from_north(place: Floats) -> Array:
    """Return places (..., 2), x to the east and y to the north, of those that say north first, then east [m].

    Bounds for each axis turn in the same way. Raises `InvalidInput` unless there are two finite numbers for each place.
    """
    places = finite("north and east [m]", place)
    if not places.ndim or places.shape[-1] != 2:
        raise InvalidInput("places as north and east, (..., 2)", f"shape {places.shape}")
    return places[..., ::-1].copy()
