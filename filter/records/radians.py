"""Angles that can only be degrees are refused at the door, whatever they are called.

A bearing may be the difference of angles, and one of these a yaw that was not wrapped for a turn or two: so it may be up to
four turns, which bearings in degrees are not for long. A heading may be any number: a yaw that was never wrapped is honest. But
no compass that may be off by more than a right angle counts turns, so there it is the bound that tells; one of pi says nothing,
and does no harm.
"""

import numpy as np

from filter.arrays import Array
from filter.errors import InvalidInput

TWO_TURNS, FOUR_TURNS, RIGHT_ANGLE = 4 * np.pi, 8 * np.pi, np.pi / 2
REMEDY = "numpy.radians makes radians of degrees"


def heading_in_radians(heading: Array, bound: Array) -> None:
    """Raise `InvalidInput` if any of (k,) headings with their bounds can only be in degrees."""
    wrong = heading[(np.abs(heading) > TWO_TURNS) & (bound > RIGHT_ANGLE) & (bound < np.pi)]
    if len(wrong):
        expected = f"heading [rad]: beyond two turns a bound of at most pi/2 ({REMEDY}, or see Compass.from_north)"
        raise InvalidInput(expected, wrong[0].item())


def bearing_in_radians(bearing: Array, name: str = "bearing") -> None:
    """Raise `InvalidInput` if any of (k,) bearings, or other angles as seen from a robot, can only be in degrees."""
    wrong = bearing[np.abs(bearing) > FOUR_TURNS]
    if len(wrong):
        expected = f"{name} [rad]: no more than four turns ({REMEDY}, wrap takes whole turns off)"
        raise InvalidInput(expected, wrong[0].item())
