"""Hyperbolas: half-planes hold all of a polygon with such a difference of distances, and little besides."""

import numpy as np
import pytest

from filter import Polygon
from filter.geometry.hyperbola import of_difference

SQUARE = Polygon.box([-6, -5], [6, 5])


def slack(half_planes, points):
    """Return (p,) how far inside of all half-planes points are; infinite where there is none."""
    normals, offsets = half_planes
    return (offsets - points @ normals.T).min(axis=1, initial=np.inf)


def differences(points, places):
    return np.hypot(*(points - places[0]).T) - np.hypot(*(points - places[1]).T)


def drawn(rng):
    """Return a polygon, two places and points in it: scales, flat polygons, points on the axis, at places and on the rim."""
    scale, shift = 10.0 ** rng.integers(-2, 4), rng.choice([0.0, 5e5]) * rng.normal(size=2)
    corners = rng.normal(size=(rng.integers(1, 9), 2)) * scale * rng.choice([1, 1e-3, 0], size=2, p=[0.7, 0.2, 0.1])
    polygon, places = Polygon.hull(corners + shift), rng.normal(size=(2, 2)) * scale * rng.choice([0.1, 1, 5]) + shift
    shares = rng.dirichlet(np.full(len(polygon.vertices), 0.3), size=40)
    return polygon, places, np.concatenate([shares @ polygon.vertices, polygon.vertices])


def test_every_place_with_such_a_difference_is_held():
    rng = np.random.default_rng(1)
    for _ in range(600):
        polygon, places, points = drawn(rng)
        exact, distance = differences(points, places), np.hypot(*(places[1] - places[0]))
        value = rng.choice([*exact, *(rng.choice([-1, 0, 1, 0.999, -0.999], 3) * distance)])
        bound = rng.choice([0, 1e-3, 0.1, 1]) * distance * rng.random()
        found = of_difference(polygon, places, value - bound, value + bound, int(rng.integers(2, 20)))
        inside = np.abs(exact - value) <= bound
        assert (slack(found, points[inside]) >= -1e-14 * np.abs(points).max()).all()


@pytest.mark.parametrize("value", [-3.9, -2.0, -0.5, 0.0, 0.3, 2.0, 3.9, 4.0])
@pytest.mark.parametrize("bound", [0.0, 0.05, 0.6])
def test_little_is_left_besides(value, bound):
    places = np.array([[-1.5, 0.5], [2.2, -1.02]])
    grid = np.stack(np.meshgrid(np.linspace(-6, 6, 241), np.linspace(-5, 5, 201)), axis=-1).reshape(-1, 2)
    found = of_difference(SQUARE, places, value - bound, value + bound, 12)
    held = Polygon.from_half_planes(*found, *SQUARE.bounds)
    allowed = grid[np.abs(differences(grid, places) - value) <= bound + 0.05]  # neighbours on the grid differ by no more
    assert held.area <= 1.04 * Polygon.hull(allowed).area + 0.1


def test_the_half_planes_of_one_branch_are_near_its_hull():
    places = np.array([[-1.0, 0.0], [1.0, 0.0]])
    found = of_difference(SQUARE, places, -1.0, -1.0, 12)
    y = np.linspace(-5, 5, 4001)
    branch = np.stack([-np.sqrt(0.25 * (1 + y**2 / 0.75)), y], axis=1)
    held = Polygon.from_half_planes(*found, *SQUARE.bounds)
    assert Polygon.hull(branch).area <= held.area <= 1.02 * Polygon.hull(branch).area
