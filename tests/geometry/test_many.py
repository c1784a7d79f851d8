"""Many polygons at a time are what each of them is alone."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import unit

from filter.geometry.many import Polygons, clip_boxes
from filter.geometry.polygon import SIDES, Polygon, clip


def some(rng, count=7):
    """Return polygons of all kinds: with area, segments and points, near and far."""
    made = []
    for k in range(count):
        points = rng.normal(size=(int(rng.integers(1, 9)), 2)) * 10.0 ** rng.integers(-3, 3) + rng.normal(size=2) * 5
        made.append(Polygon.from_vertices(points if k else np.tile(points[:1], (3, 1))))
    return made


@pytest.mark.parametrize("seed", range(6))
def test_they_are_what_was_put_in(seed):
    rng = np.random.default_rng(seed)
    alone = some(rng)
    together = Polygons.of(alone)
    assert len(together) == len(alone)
    for mine, theirs in zip(together, alone, strict=True):
        assert mine.normals.tolist() == theirs.normals.tolist()
        assert mine.offsets.tolist() == theirs.offsets.tolist()
        assert mine.vertices.tolist() == theirs.vertices.tolist()
        assert mine.margin == theirs.margin
    assert together.areas.tolist() == [polygon.area for polygon in alone]
    assert [polygon.area for polygon in together[2:4]] == together.areas[2:4].tolist()
    assert together[-1].area == alone[-1].area
    points = np.array([polygon.centroid for polygon in alone]) + rng.normal(size=(len(alone), 2)) * rng.uniform(0, 1)
    assert together.contains(points).tolist() == [bool(each.contains(p)) for each, p in zip(alone, points, strict=True)]


@pytest.mark.parametrize("seed", range(4))
def test_each_edge_has_its_owner(seed):
    together = Polygons.of(some(np.random.default_rng(seed)))
    assert together.owner.tolist() == [k for k in range(len(together)) for _ in together[k].offsets]


@pytest.mark.parametrize("seed", range(4))
def test_some_are_turned_about_and_the_others_stay(seed):
    rng = np.random.default_rng(seed)
    alone = some(rng)
    which = rng.random(len(alone)) < 0.5
    for before, after, turned in zip(alone, Polygons.of(alone).turned_about(which), which, strict=True):
        sign = -1 if turned else 1
        assert after.vertices.tolist() == (sign * before.vertices).tolist()
        assert after.normals.tolist() == (sign * before.normals).tolist()
        assert (after.offsets.tolist(), after.margin) == (before.offsets.tolist(), before.margin)
        assert after.area == pytest.approx(before.area)


def test_beyond_the_last_there_is_none():
    with pytest.raises(IndexError):
        Polygons.of([Polygon.box([0, 0], [1, 1])])[1]
    assert len(Polygons.of([]).areas) == 0


@pytest.mark.parametrize("far", [0.0, 1e6])
@pytest.mark.parametrize("seed", range(6))
def test_places_of_which_polygons_tell_are_in_the_spans(seed, far):
    rng = np.random.default_rng(seed)
    alone = [Polygon.from_vertices(far + polygon.vertices) for polygon in some(rng)]
    sign, radius = rng.choice([-1.0, 1.0], len(alone)), rng.uniform(0, 1, len(alone)) * (rng.random(len(alone)) < 0.7)
    by = far * rng.choice([-1, 0, 1]) + rng.normal(size=(len(alone), 2))
    points = by - far * sign[:, None] + rng.normal(size=(len(alone), 2)) * 10
    spans = Polygons.of(alone).spans(sign, points, by, radius)
    assert not spans.full.all()
    for k, polygon in enumerate(alone):
        for vertex in polygon.vertices:
            way = [sign[k] * Fraction(vertex[m]) + Fraction(points[k, m]) - Fraction(by[k, m]) for m in (0, 1)]
            places = np.array([float(each) for each in way]) + radius[k] * unit(rng.uniform(-np.pi, np.pi, 30))
            assert spans[np.full(30, k)].contains(np.arctan2(places[:, 1], places[:, 0])).all()


@pytest.mark.parametrize("seed", range(12))
def test_each_box_is_cut_by_its_own_half_planes(seed):
    """Groups may have none, lie apart, or have half-planes in common; sides of boxes are numbered after all of them."""
    rng = np.random.default_rng(seed)
    groups, count = 6, 40
    normals, offsets = unit(rng.uniform(-np.pi, np.pi, count)), rng.uniform(-0.2, 1.0, count)
    begin = rng.integers(0, count, groups)
    end = np.minimum(begin + rng.integers(0, 9, groups), count)
    begin[-1] = end[-1] = count
    lower = rng.uniform(-2, -1, (groups, 2))
    upper = np.where(rng.uniform(size=(groups, 2)) < 0.1, lower, lower + rng.uniform(1, 4, (groups, 2)))
    clipped = clip_boxes(normals, offsets, (begin, end), lower, upper)
    for g in range(groups):
        rows = np.arange(begin[g], end[g])
        alone = clip(normals[rows], offsets[rows], lower[g], upper[g])
        assert clipped.empty[g] == (alone is None)
        expected, behind = (Polygon.box(lower[g], upper[g]), len(rows) + np.arange(4)) if alone is None else alone
        numbers = np.append(rows, count + np.arange(4))
        mine = clipped.behind[clipped.polygons.first[g] : clipped.polygons.first[g + 1]]
        assert mine.tolist() == numbers[behind].tolist()
        found, sides = clipped.polygons[g], np.concatenate([upper[g], -lower[g]])
        assert found.vertices == pytest.approx(expected.vertices, abs=1e-14)
        assert found.normals.tolist() == np.concatenate([normals, SIDES])[mine].tolist()
        assert found.offsets.tolist() == np.append(offsets, sides)[mine].tolist()


def test_no_boxes_are_no_polygons():
    none = np.zeros(0, dtype=np.int64)
    clipped = clip_boxes(unit(np.zeros(3)), np.ones(3), (none, none), np.zeros((0, 2)), np.zeros((0, 2)))
    assert (len(clipped.polygons), len(clipped.behind), len(clipped.empty)) == (0, 0, 0)
