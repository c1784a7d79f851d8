"""The hull of regions, the arc around headings: they contain all, and not much more."""

import numpy as np
import pytest

from filter.diagnosis.cover import arcs_around, hulls_of
from filter.geometry.angles import AngularIntervals
from filter.geometry.around import lines_around
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


def test_the_hull_of_the_same_is_the_same():
    box = Polygon.box([0, 0], [1, 2])
    normals, offsets, first = lines_around([Polygons.of([box]), Polygons.of([Polygon.box([0, 0], [1, 2])])])
    assert (normals == box.normals).all()
    assert (offsets == box.offsets).all()
    assert first.tolist() == [0, 4]
    assert hull_of([box, Polygon.box([0, 0], [1, 3])]).area == pytest.approx(3.0)


def test_hulls_of_lists_are_each_of_its_own():
    lists = [Polygons.of([Polygon.box([k, 0], [k + 1, 1]), Polygon.box([0, 0], [1, 1])]) for k in range(3)]
    assert hulls_of(lists).areas == pytest.approx([3.0, 1.0])


@pytest.mark.parametrize("seed", range(60))
def test_an_arc_contains_each_arc_also_behind(seed):
    rng = np.random.default_rng(seed)
    count, middle = int(rng.integers(1, 6)), rng.choice([0.0, np.pi, rng.uniform(-np.pi, np.pi)])
    several = [
        AngularIntervals(middle + rng.uniform(-1, 1, 3), rng.choice([0.0, 0.3, 2.0, np.pi], 3, p=[0.3, 0.4, 0.2, 0.1]))
        for _ in range(count)
    ]
    around = arcs_around(several)
    for arcs in several:
        for share in (-1.0, -0.3, 0.0, 0.9, 1.0):
            angles = arcs.centre + share * np.minimum(arcs.bound, np.pi) * (1 - 1e-15)
            inside = arcs.contains(angles)
            assert (around.contains(angles) | ~inside).all()
    least = np.max([arcs.bound for arcs in several], axis=0)
    assert (around.bound >= least - 1e-12).all()


def test_arcs_on_both_sides_of_the_cut_are_joined_there():
    around = arcs_around([AngularIntervals([np.pi - 0.2], [0.1]), AngularIntervals([-np.pi + 0.3], [0.1])])
    assert around.bound[0] == pytest.approx(0.35)
    assert around.contains(np.pi)[0]
    assert not around.contains(0.0)[0]
