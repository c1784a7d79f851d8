"""What is around polygons contains all of them, bit by bit, and is not much more than their hull."""

import numpy as np
import pytest

from filter.geometry.around import hulls_of, lines_around
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon


def drawn(rng, where):
    """Return a polygon, a segment or a point, near a place or far off."""
    points = where + rng.normal(size=(int(rng.integers(1, 8)), 2)) * 10.0 ** rng.integers(-3, 3)
    return Polygon.from_vertices(points)


def hull_of(polygons):
    """Return the polygon around some others."""
    return hulls_of([Polygons.of([polygon]) for polygon in polygons])[0]


@pytest.mark.parametrize("seed", range(60))
def test_a_hull_contains_each_polygon_bit_by_bit(seed):
    rng = np.random.default_rng(seed)
    where = rng.choice([0.0, 1.0, 5e6]) * rng.normal(size=2)
    polygons = [drawn(rng, where) for _ in range(int(rng.integers(2, 6)))]
    hull = hull_of(polygons)
    for polygon in polygons:
        corner, shares = polygon.vertices, rng.dirichlet(np.ones(len(polygon.vertices)), 20)
        points = np.concatenate([corner, shares @ corner])
        points = points[polygon.contains(points)]
        assert hull.contains(points).all()
        assert (polygon.support(hull.normals) <= hull.offsets).all()
    around = Polygon.hull(np.concatenate([polygon.vertices for polygon in polygons]))
    size = np.abs(around.vertices).max()
    assert hull.area <= around.area + 1e-9 * size * (1 + np.ptp(around.vertices, axis=0).sum())


@pytest.mark.parametrize("seed", range(20))
def test_lines_are_those_of_each_place_by_itself(seed):
    """The slow and obvious version: the hull of all vertices, pushed outward to the greatest of the supports."""
    rng = np.random.default_rng(seed)
    lists = [[drawn(rng, rng.normal(size=2)) for _ in range(4)] for _ in range(int(rng.integers(2, 5)))]
    normals, offsets, first = lines_around([Polygons.of(polygons) for polygons in lists])
    for k, several in enumerate(zip(*lists, strict=True)):
        mine = slice(first[k], first[k + 1])
        hull = Polygon.hull(np.concatenate([polygon.vertices for polygon in several]))
        assert normals[mine] == pytest.approx(hull.normals, abs=1e-9)
        most = np.max([polygon.support(normals[mine]) for polygon in several], axis=0)
        assert (offsets[mine] >= most).all()
        assert offsets[mine] == pytest.approx(most, rel=0, abs=1e-14 * np.abs(hull.vertices).max())


def test_the_lines_around_the_same_are_their_own():
    box = Polygon.box([0, 0], [1, 2])
    normals, offsets, first = lines_around([Polygons.of([box]), Polygons.of([Polygon.box([0, 0], [1, 2])])])
    assert (normals == box.normals).all()
    assert (offsets == box.offsets).all()
    assert first.tolist() == [0, 4]
    assert hull_of([box, Polygon.box([0, 0], [1, 3])]).area == pytest.approx(3.0)


def test_hulls_of_lists_are_each_of_its_own():
    lists = [Polygons.of([Polygon.box([k, 0], [k + 1, 1]), Polygon.box([0, 0], [1, 1])]) for k in range(3)]
    assert hulls_of(lists).areas == pytest.approx([3.0, 1.0])
