"""What counts from north, against sine and cosine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filter import InvalidInput, heading_from_north, place_from_north

ANGLES = st.floats(-50.0, 50.0)
CLOSE = 1e-12


@given(ANGLES, st.floats(-1.0, 1.0))
def test_east_is_the_sine_and_north_the_cosine_of_what_is_east_of_true_north(angle, declination):
    """A needle that points east of north makes angles from it too small."""
    heading, true = heading_from_north(angle, declination), angle + declination
    assert -np.pi < heading <= np.pi
    assert np.allclose([np.cos(heading), np.sin(heading)], [np.sin(true), np.cos(true)], rtol=0, atol=100 * CLOSE)


@pytest.mark.parametrize(
    ("degrees", "heading"), [(0, 90), (90, 0), (180, -90), (270, 180), (-90, 180), (360, 90), (45, 45), (350, 100), (450, 0)]
)
def test_the_points_of_the_compass(degrees, heading):
    assert np.degrees(heading_from_north(np.radians(degrees))) == pytest.approx(heading, abs=1e-9)


def test_headings_keep_their_shape():
    assert heading_from_north(0.1).shape == ()
    assert heading_from_north([[0.1, 0.2, 0.3]], 0.05).shape == (1, 3)


@pytest.mark.parametrize("place", [[3.0, 4.0], [[3.0, 4.0], [-1.0, 2.0]], [[[3.0, 4.0]]]])
def test_a_place_north_first_and_back_is_the_same_place(place):
    turned = place_from_north(place)
    assert turned.shape == np.shape(place)
    assert turned.ravel()[:2].tolist() == [4.0, 3.0]
    assert place_from_north(turned).tolist() == place


@pytest.mark.parametrize("wrong", [3.0, [3.0], [1.0, 2.0, 3.0], [1.0, np.nan], "north", [[1.0, 2.0], [3.0, np.inf]]])
def test_what_is_no_place_is_refused(wrong):
    with pytest.raises(InvalidInput, match="north and east"):
        place_from_north(wrong)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, "north", None])
def test_what_is_no_angle_is_refused(wrong):
    with pytest.raises(InvalidInput, match="from north"):
        heading_from_north(wrong)
    with pytest.raises(InvalidInput, match="declination"):
        heading_from_north(0.0, wrong)
