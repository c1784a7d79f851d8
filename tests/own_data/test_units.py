"""Units, conventions and stamps at the door, against formulas that are not the code's own."""

import cmath
import math
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.own_data.units import Door, local_plane, mirrored, nanoseconds, seconds, wrapped, yaw
from filter import InvalidInput

ANGLES = st.floats(-6.0, 6.0)
PLACES = st.floats(-1e3, 1e3)
CLOSE = 1e-9


def apart(a, b):
    """Return how far apart two angles are, on the circle."""
    return abs(cmath.phase(cmath.exp(1j * (a - b))))


@given(ANGLES)
def test_a_heading_from_north_points_where_sine_and_cosine_say(north):
    """Clockwise from north: east is the sine, north the cosine."""
    heading = Door(convention="ned").heading(north)
    assert abs(math.cos(heading) - math.sin(north)) < CLOSE
    assert abs(math.sin(heading) - math.cos(north)) < CLOSE
    assert -math.pi < heading <= math.pi


@given(ANGLES)
def test_a_heading_from_east_stays_but_for_whole_turns(heading):
    found = Door().heading(heading)
    assert apart(found, heading) < CLOSE
    assert found == heading or not -math.pi < heading <= math.pi


@given(st.floats(-360, 360), st.sampled_from(["enu", "ned"]))
def test_degrees_are_radians_of_another_name(degrees, convention):
    in_degrees = Door("degrees", declared=True, convention=convention).heading(degrees)
    assert apart(in_degrees, Door(convention=convention).heading(degrees * math.pi / 180)) < CLOSE


@given(ANGLES, st.floats(-0.5, 0.5))
def test_a_needle_that_points_east_of_north_is_corrected_to_the_east_in_both_conventions(north, declination):
    """True north lies `declination` to the left of where the needle points."""
    true = north + declination
    by_ned = Door(declared=True, convention="ned", declination=declination).heading(north)
    by_enu = Door(declared=True, declination=declination).heading(math.pi / 2 - north)
    assert apart(by_ned, math.pi / 2 - true) < CLOSE
    assert apart(by_enu, math.pi / 2 - true) < CLOSE


@given(PLACES, PLACES, ANGLES, st.floats(0.1, 9.0), ANGLES)
def test_what_is_seen_to_the_right_is_there_in_both_conventions(north, east, heading, distance, bearing):
    """A target's place, worked out in north, east, clockwise; and in the log's own sense."""
    target = north + distance * math.cos(heading + bearing), east + distance * math.sin(heading + bearing)
    door = Door(convention="ned", declared=True)
    x, y = door.place(north, east)
    way = door.heading(heading) + door.bearing(bearing)
    found = x + distance * math.cos(way), y + distance * math.sin(way)
    assert found == pytest.approx(door.place(*target), abs=1e-6)
    assert apart(door.turn(bearing), door.bearing(bearing)) < CLOSE


@given(st.floats(-0.2, 0.2), st.floats(0, 0.4), st.floats(0, 1), ANGLES)
def test_a_one_sided_bound_is_mirrored_with_its_angle(low, width, share, true):
    high = low + width
    error = low + share * width
    door = Door(convention="ned", declared=True)
    least, greatest = door.angle_bound((low, high))
    off = wrapped(door.bearing(true + error) - door.bearing(true))
    assert least - CLOSE <= off <= greatest + CLOSE
    assert mirrored(mirrored((low, high))) == (low, high)


@given(st.floats(-1e6, 1e6), st.sampled_from([("metres", 1), ("centimetres", 100), ("millimetres", 1000)]))
def test_lengths_are_divided_by_how_many_are_a_metre(value, unit):
    name, count = unit
    assert Door(length=name).distance(value) == float(Decimal(value) / count)


@given(st.integers(-(10**18), 2 * 10**18))
def test_stamps_are_rounded_once(stamp):
    assert seconds(stamp) == float(Decimal(stamp) / 10**9)


@given(st.integers(0, 2 * 10**18))
def test_stamps_in_any_unit_are_exact(stamp):
    for unit, places in (("ns", 0), ("us", 3), ("ms", 6), ("s", 9)):
        text = f"{stamp // 10**places}.{stamp % 10**places:0{places}d}" if places else str(stamp)
        assert nanoseconds(text, unit) == stamp
    assert nanoseconds(stamp, "ns") == stamp


@pytest.mark.parametrize("stamp", ["", "noon", "nan", "inf", None])
def test_what_is_no_stamp_is_refused(stamp):
    with pytest.raises(InvalidInput, match=r"a stamp \[s\]"):
        nanoseconds(stamp, "s")


@given(st.floats(-math.pi, math.pi), st.floats(-1.5, 1.5), st.floats(-math.pi, math.pi), st.floats(0.95, 1.05))
def test_the_yaw_of_a_quaternion_is_where_its_forward_axis_points(heading, pitch, roll, length):
    """The rotation's matrix is worked out from three turns about axes, its first column is the forward axis."""
    parts = [(heading, 2), (pitch, 1), (roll, 0)]
    x, y, z, w = np.array([0.0, 0.0, 0.0, 1.0])
    for angle, axis in parts:
        v = np.zeros(3)
        v[axis] = math.sin(angle / 2)
        s, u = math.cos(angle / 2), np.array([x, y, z])
        (x, y, z), w = w * v + s * u + np.cross(u, v), w * s - u @ v
    assert apart(yaw(x * length, y * length, z * length, w * length), heading) < 1e-6


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0), (math.nan, 0.0, 0.0, 1.0)])
def test_what_is_no_rotation_has_no_yaw(quaternion):
    assert yaw(*quaternion) is None


@pytest.mark.parametrize(("angle", "passes"), [(6.3, True), (-6.3, True), (6.4, False), (90.0, False), (-45.0, False)])
def test_what_can_only_be_degrees_is_refused_unless_radians_are_declared(angle, passes):
    for convert in (Door().heading, Door().bearing):
        if passes:
            convert(angle)
        else:
            with pytest.raises(InvalidInput, match='unit = "degrees"'):
                convert(angle)
    assert apart(Door(declared=True).heading(angle), angle) < CLOSE


def earth_centred(latitude, longitude):
    """Return where a place on the ellipsoid is [m]."""
    a, e2 = 6378137.0, 0.0066943799901413165
    north, east = math.radians(latitude), math.radians(longitude)
    across = a / math.sqrt(1 - e2 * math.sin(north) ** 2)
    around = across * math.cos(north)
    return np.array([around * math.cos(east), around * math.sin(east), across * (1 - e2) * math.sin(north)])


@given(st.floats(-60, 60), st.floats(-170, 170), st.floats(-0.03, 0.03), st.floats(-0.03, 0.03))
def test_a_place_near_the_origin_is_where_the_ellipsoid_has_it(latitude, longitude, north, east):
    """In the plane that touches the ellipsoid at the origin, which differs from ours by the third order only."""
    pytest.importorskip("pyproj")
    offset = earth_centred(latitude + north, longitude + east) - earth_centred(latitude, longitude)
    lat, lon = math.radians(latitude), math.radians(longitude)
    to_east = np.array([-math.sin(lon), math.cos(lon), 0.0])
    to_north = np.array([-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)])
    found = local_plane(latitude, longitude)(latitude + north, longitude + east)
    distance = np.linalg.norm(offset)
    assert found == pytest.approx((to_east @ offset, to_north @ offset), abs=1e-6 + distance**3 / 6.3e6**2)
