"""Where the checker says that sensors can be: where they are, and nowhere that the filter does not say."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import unit
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.proof.arms import around, beyond, reach
from experiments.proof.edges import plane
from experiments.proof.exact import Arc, arc_around
from experiments.proof.given.sensors import CENTRE, Mounts
from experiments.proof.reading import Broken
from experiments.proof.shown import dot
from filter import AngularIntervals, Bearing, Sensor, Team
from filter.sensing.arms import Arms
from filter.sensing.readings import Readings

seeds = st.integers(0, 2**32 - 1)
NORMALS = unit(np.linspace(-np.pi, np.pi, 24, endpoint=False) + 0.01)
ONE = np.zeros(1, dtype=int)  # the only reading
NOWHERE = [(Fraction(0), Fraction(0))]
ROUNDING = 1e-12  # of the places of sensors, which are made in floats


def drawn(rng):
    """Return two sensors, as a log says them, and how two robots can look, often nearly anyhow."""
    sensors = {}
    for name in ("camera", "tag"):
        place = rng.uniform(-1, 1, 2) * rng.choice([0.0, 1e-9, 0.3, 20.0])
        sensors[name] = {"position": place.tolist(), "position_bound": float(rng.choice([0.0, 0.01, 1.0]))}
    looks = rng.uniform(-np.pi, np.pi, 2), rng.choice([0.0, 1e-9, 0.2, 1.5, np.pi / 2, 1.8, 3.0, np.pi], 2)
    return sensors, looks


def places_of(rng, sensor, centre, bound):
    """Return some places of a sensor, as seen from its robot's centre, at the ends of all bounds and within."""
    headings = centre + bound * np.append([-1.0, 1.0, 0.0], rng.uniform(-1, 1, 20))
    off = sensor["position_bound"] * unit(rng.uniform(-np.pi, np.pi, 23))
    at = np.array(sensor["position"]) + off
    sine, cosine = np.sin(headings), np.cos(headings)
    return np.stack([cosine * at[:, 0] - sine * at[:, 1], sine * at[:, 0] + cosine * at[:, 1]], axis=1)


@settings(max_examples=40, deadline=None)
@given(seeds)
def test_all_places_of_a_sensor_are_within(seed):
    rng = np.random.default_rng(seed)
    sensors, (centre, bound) = drawn(rng)
    mounts = Mounts(sensors)
    both, arcs = mounts.pair([0, 1]), [arc_around(*map(float, each)) for each in zip(centre, bound, strict=True)]
    here, there = (places_of(rng, sensor, *each) for sensor, *each in zip(sensors.values(), centre, bound, strict=True))
    size = 1 + max(np.abs(here).max(), np.abs(there).max())
    hull, more = around(NOWHERE, both, (0, 1), dict(enumerate(arcs))), (there[:, None] - here).reshape(-1, 2)
    for normal in NORMALS:
        exact = plane(normal.tolist())
        assert (here @ normal).max() <= float(reach(both[0], arcs[0], exact)) + ROUNDING * size
        assert (-more @ normal).max() <= float(beyond(both, (0, 1), arcs, exact)) + ROUNDING * size
        assert (more @ normal).max() <= float(max(dot(exact, corner) for corner in hull)) + ROUNDING * size


@settings(max_examples=40, deadline=None)
@given(seeds)
def test_the_filter_says_no_less(seed):
    rng = np.random.default_rng(seed)
    sensors, (centre, bound) = drawn(rng)
    team = Team(2, sensors=[Sensor(name, **each) for name, each in sensors.items()])
    readings = Readings.of(0.0, [Bearing(0.0, 0, 1, 0.0, 0.1, 0, 1)], mountings=team.mountings)
    arms = Arms.of(readings, AngularIntervals(centre, bound), 2)
    both = Mounts(sensors).pair([0, 1])
    if arms is None:
        assert all(mount.is_at_the_centre for mount in both)
        return
    arcs = [arc_around(*map(float, each)) for each in zip(centre, bound, strict=True)]
    corners, (by, radius) = arms.seen(0, from_other=False), arms.between(ONE)
    for normal in NORMALS:
        exact, back = plane(normal.tolist()), plane((-normal).tolist())
        one, other = arms.own.support(ONE, normal[None]), arms.others.support(ONE, -normal[None])
        assert reach(both[0], arcs[0], back) <= Fraction(one[0].item())
        assert beyond(both, (0, 1), arcs, back) <= Fraction(one[0].item()) + Fraction(other[0].item())
        assert beyond(both, (0, 1), arcs, exact) <= Fraction(float(by[0] @ normal + radius[0]))
        most = max(dot(exact, corner) for corner in around(NOWHERE, both, (0, 1), dict(enumerate(arcs))))
        assert float(most) <= (corners @ normal).max() + ROUNDING * (1 + np.abs(corners).max())


@pytest.mark.parametrize("half", [0.3, 1.5, np.pi / 2, 1.7, 3.0, np.pi, 4.0])
def test_what_a_wide_arc_leaves_out_it_does_not_contain(half):
    for middle in (0.0, 3.0, -9.0):
        arc = Arc.between(Fraction(middle - half), Fraction(middle + half))
        for angle in np.linspace(-np.pi, np.pi, 37):
            within = abs(np.angle(np.exp(1j * (angle - middle)))) <= half
            assert arc.may_contain(plane(unit(angle).tolist())) >= within
            if half != np.pi / 2 and half < 3.1 and abs(abs(np.angle(np.exp(1j * (angle - middle)))) - half) > 1e-6:
                assert arc.may_contain(plane(unit(angle).tolist())) == within


def test_where_sensors_are_in_one_place_for_sure():
    off = {"position_bound": 0.01}
    sensors = {
        "a": {"position": [1, 0]},
        "b": {"position": [1, 0], "angle": 3},
        "c": {"position": [1, 0], **off},
        "d": off,
        "e": {},
    }
    mounts = Mounts(sensors)
    spots = [mounts.of(name).spot for name in sensors]
    assert spots == Team(1, sensors=[Sensor(name, **each) for name, each in sensors.items()]).mountings.spot[:-1].tolist()
    assert mounts.of(None) is CENTRE
    assert mounts.of(1) == mounts.of("b")
    for wrong in ("f", 5, -1, True, 1.0):
        with pytest.raises(Broken):
            mounts.of(wrong)


@pytest.mark.parametrize(
    "wrong", [{"place": [1, 0]}, {"position_bound": -0.1}, {"angle": 6.3}, {"angle_bound": 3.2}, {"angle": None}, 1, None]
)
def test_a_sensor_of_another_form_is_refused(wrong):
    with pytest.raises(Broken):
        Mounts({"camera": wrong})
