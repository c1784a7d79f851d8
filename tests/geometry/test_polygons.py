"""Many polygons at a time are what each of them is alone."""

import numpy as np
import pytest
from filter.geometry.polygons import Polygons, cut_boxes, joined, places
from helpers.worlds import unit

from filter.geometry.polygon import Polygon, clip


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
def test_some_of_them_and_others_after_them(seed):
    rng = np.random.default_rng(seed)
    alone = some(rng)
    index = rng.integers(0, len(alone), 10)
    chosen = Polygons.of(alone).select(index)
    both = Polygons.concatenate([chosen, Polygons.of(alone)])
    assert both.areas.tolist() == [alone[k].area for k in index] + [polygon.area for polygon in alone]
    assert both[3].vertices.tolist() == alone[index[3]].vertices.tolist()
    assert both.owner.tolist() == [k for k in range(len(both)) for _ in both[k].offsets]


def test_beyond_the_last_there_is_none():
    with pytest.raises(IndexError):
        Polygons.of([Polygon.box([0, 0], [1, 1])])[1]
    assert len(Polygons.of([]).areas) == 0


@pytest.mark.parametrize("seed", range(6))
def test_points_seen_from_polygons_are_in_their_spans(seed):
    rng = np.random.default_rng(seed)
    alone = some(rng)
    points = rng.normal(size=(len(alone), 2)) * 20
    seen = Polygons.of(alone).mirrored(points)
    spans = seen.spans()
    for k, polygon in enumerate(alone):
        there = rng.dirichlet(np.ones(len(polygon.vertices)), 50) @ polygon.vertices
        assert ((points[k] - there) @ seen[k].normals.T <= seen[k].offsets + 1e-11).all()
        directions = points[k] - there
        assert spans[np.full(50, k)].contains(np.arctan2(directions[:, 1], directions[:, 0])).all()


@pytest.mark.parametrize("seed", range(6))
def test_each_box_is_cut_by_its_own_half_planes(seed):
    rng = np.random.default_rng(seed)
    groups, count = 6, 40
    normals, offsets = unit(rng.uniform(-np.pi, np.pi, count)), rng.uniform(-0.2, 1.0, count)
    whose = np.sort(rng.integers(0, groups - 1, count))  # the last group has no half-plane
    order = rng.permutation(count)
    order = order[np.argsort(whose[order], kind="stable")]
    begin, end = np.searchsorted(whose[order], np.arange(groups)), np.searchsorted(whose[order], np.arange(groups), "right")
    lower = rng.uniform(-2, -1, (groups, 2))
    upper = np.where(rng.uniform(size=(groups, 2)) < 0.1, lower, lower + rng.uniform(1, 4, (groups, 2)))
    cuts = cut_boxes(normals, offsets, (order, begin, end), lower, upper)
    for g in range(groups):
        rows = order[begin[g] : end[g]]
        alone = clip(normals[rows], offsets[rows], lower[g], upper[g])
        assert cuts.empty[g] == (alone is None)
        expected = Polygon.box(lower[g], upper[g]) if alone is None else alone[0]
        assert np.sort(cuts.polygons[g].vertices, axis=0) == pytest.approx(np.sort(expected.vertices, axis=0), abs=1e-14)
        if alone is not None:
            behind = cuts.edges[cuts.polygons.first[g] : cuts.polygons.first[g + 1]]
            assert behind.tolist() == [rows[edge] if edge >= 0 else edge for edge in alone[1]]
            assert cuts.polygons[g].normals.tolist() == expected.normals.tolist()
            assert cuts.polygons[g].offsets.tolist() == expected.offsets.tolist()


def test_pieces_of_lists():
    at, first = places(np.array([0, 2, 2, 5]), np.array([2, 1, 0, 2]))
    assert at.tolist() == [2, 3, 4, 0, 1, 2, 3, 4]
    assert first.tolist() == [0, 3, 3, 5, 8]
    assert joined([np.array([0, 2, 3]), np.array([0]), np.array([0, 1])]).tolist() == [0, 2, 3, 4]
