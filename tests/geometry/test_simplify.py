"""What greedy removal of edges and of vertices says of itself, and the slow and obvious way to do it."""

import numpy as np
import pytest
from helpers.worlds import unit
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.convex import area_of, hull_of
from filter.geometry.polygon import clip
from filter.geometry.simplify import edges_worth_keeping, vertices_worth_keeping

seeds = st.integers(0, 2**32 - 1)
FAR = 1e3  # a box so wide counts nothing [m]; what reaches there is not bounded otherwise


def some_polygon(rng, lines=14):
    """Return a polygon with edges of half-planes and of a box, and which are of half-planes."""
    polygon, behind = clip(
        unit(np.sort(rng.uniform(0, 2 * np.pi, lines))), rng.uniform(0.8, 1.0, lines), np.full(2, -5.0), np.full(2, 5.0)
    )
    return polygon, behind < lines


def area_with(polygon, keep):
    """Return the area that some of the edges bound; infinite where they do not."""
    rest = clip(polygon.normals[keep], polygon.offsets[keep], np.full(2, -FAR), np.full(2, FAR))[0]
    return np.inf if np.abs(rest.vertices).max() > FAR / 2 else rest.area


def edges_slowly(polygon, removable, budget, allowance):
    """Return what `edges_worth_keeping` does, with whole areas of all that is left after each removal."""
    keep, spent, area = np.ones(len(removable), dtype=bool), 0.0, polygon.area
    while (keep & removable).any():
        fewer = {}
        for edge in np.flatnonzero(keep & removable):
            keep[edge] = False
            fewer[edge] = area_with(polygon, keep) - area
            keep[edge] = True
        least = min(fewer, key=fewer.get)
        if (keep & removable).sum() <= budget and not spent + fewer[least] <= allowance:
            break
        if not np.isfinite(fewer[least]):
            return None  # several may be as bad
        keep[least], spent, area = False, spent + fewer[least], area + fewer[least]
    return keep


@given(seeds, st.integers(3, 8), st.floats(0, 0.5))
def test_what_removal_says_it_adds_is_what_it_adds(seed, budget, share):
    polygon, removable = some_polygon(np.random.default_rng(seed))
    keep, spent = edges_worth_keeping(polygon.normals, polygon.offsets, removable, budget, share * polygon.area)
    rest = clip(polygon.normals[keep], polygon.offsets[keep], np.full(2, -FAR), np.full(2, FAR))[0]
    assert keep[~removable].all()
    assert keep[removable].sum() <= budget
    if np.isfinite(spent):
        assert rest.area == pytest.approx(polygon.area + spent, rel=1e-6)
        assert spent <= share * polygon.area or keep[removable].sum() == min(budget, removable.sum())


@given(seeds, st.integers(3, 14), st.sampled_from([-1.0, 0.0, 0.01, 0.3]))
def test_the_edges_that_are_kept_are_those_of_the_slow_way(seed, budget, share):
    polygon, removable = some_polygon(np.random.default_rng(seed))
    slowly = edges_slowly(polygon, removable, budget, share * polygon.area)
    if slowly is not None:
        keep, _ = edges_worth_keeping(polygon.normals, polygon.offsets, removable, budget, share * polygon.area)
        assert keep.tolist() == slowly.tolist()


def test_of_no_edges_none_are_kept():
    keep, spent = edges_worth_keeping(np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=bool), 4, 1.0)
    assert (len(keep), spent) == (0, 0.0)


def vertices_slowly(vertices, allowance):
    """Return what `vertices_worth_keeping` does, with whole areas of all that is left after each removal."""
    keep, spent = np.ones(len(vertices), dtype=bool), 0.0
    while keep.sum() > 3:
        area = area_of(vertices[keep])
        fewer = {}
        for vertex in np.flatnonzero(keep):
            keep[vertex] = False
            fewer[vertex] = area - area_of(vertices[keep])
            keep[vertex] = True
        least = min(fewer, key=fewer.get)
        spent += fewer[least]
        if not spent <= allowance:
            break
        keep[least] = False
    return keep


@given(seeds, st.sampled_from([0.0, 1e-3, 0.05, 0.5, 9.0]))
def test_the_vertices_that_are_kept_are_those_of_the_slow_way(seed, share):
    rng = np.random.default_rng(seed)
    vertices = hull_of(rng.normal(size=(int(rng.integers(1, 40)), 2)))
    allowance = share * area_of(vertices)
    keep = vertices_worth_keeping(vertices, allowance)
    assert keep.tolist() == vertices_slowly(vertices, allowance).tolist()
    assert area_of(vertices) - area_of(vertices[keep]) <= allowance + 1e-12
    assert keep.sum() >= min(3, len(vertices))


def test_vertices_that_coincide_or_lie_on_a_side_cost_nothing():
    square = np.array([[0.0, 0], [1, 0], [2, 0], [2, 0], [2, 2], [2, 2], [0, 2], [0, 2], [0, 1]])
    keep = vertices_worth_keeping(square, 0.0)
    assert area_of(square[keep]) == 4.0
    assert keep.sum() == 4
    assert vertices_worth_keeping(square, -1.0).all()
