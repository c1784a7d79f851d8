"""Claims and what proves them: taken apart and put together again, against the slow and obvious way."""

import numpy as np
import pytest
from helpers.programs import everybody, excess, merged_team

from filter.arrays import places
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD
from filter.projection.claims import Hulls, Outlines, Weights, in_order
from filter.projection.stop import Stop
from filter.projection.team import Projector
from filter.projection.window import Window

NONE = np.zeros(0, dtype=int)


def random_weights(rng, count):
    """Return weights, and the list of each claim's rows and multipliers that they stand for."""
    lists = [[(int(row), float(rng.exponential(1))) for row in rng.permutation(20)[: rng.integers(0, 4)]] for _ in range(count)]
    flat = [pair for each in lists for pair in each]
    row, weight = np.array([row for row, _ in flat], dtype=int), np.array([weight for _, weight in flat])
    return Weights(row, weight, np.cumsum([0, *map(len, lists)])), lists


def as_lists(weights):
    return [list(zip(*(part.tolist() for part in weights.rests_on(k)), strict=True)) for k in range(len(weights))]


def random_hulls(rng, count):
    polygons = [Polygon.hull(rng.normal(size=(6, 2))) if rng.random() < 0.7 else None for _ in range(count)]
    return Hulls.of(polygons), polygons


def corners_of(hulls):
    return [hulls.corners[hulls.first[k] : hulls.first[k + 1]].tolist() for k in range(len(hulls))]


def corners_put_in(polygons):
    return [[] if polygon is None else polygon.vertices.tolist() for polygon in polygons]


def content(outlines, k):
    """Return everything that some outlines say of one robot or pair."""
    edges = range(outlines.outer.first[k], outlines.outer.first[k + 1])
    polygon = outlines.outer[k]
    return (
        *(getattr(polygon, name).tolist() for name in ("normals", "offsets", "vertices")),
        polygon.margin,
        [as_lists(outlines.weights)[edge] for edge in edges],
        corners_of(outlines.inner)[k],
        int(outlines.searches[k]),
        outlines.reasons[k],
    )


def contents(outlines):
    return [content(outlines, k) for k in range(len(outlines.outer))]


def walked(polytope):
    return everybody(Stop()).robots(polytope).outlines


@pytest.mark.parametrize("seed", range(5))
def test_what_is_found_in_pieces_is_where_each_piece_says(seed):
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, 4, 8)
    first = np.cumsum([0, *counts])
    index = rng.integers(0, 8, 11)
    found, begins = places(first, index)
    wanted = [list(range(first[k], first[k + 1])) for k in index]
    assert found.tolist() == [place for piece in wanted for place in piece]
    assert begins.tolist() == np.cumsum([0, *map(len, wanted)]).tolist()


@pytest.mark.parametrize("seed", range(8))
def test_weights_are_lists(seed):
    rng = np.random.default_rng(seed)
    (one, its), (other, others) = random_weights(rng, 7), random_weights(rng, int(rng.integers(0, 5)))
    assert as_lists(one) == its
    assert len(one) == 7
    assert one.counts.tolist() == [len(each) for each in its]
    assert as_lists(Weights.concatenate([one, other, one])) == its + others + its
    index = rng.integers(0, 7, 12)
    assert as_lists(one.select(index)) == [its[k] for k in index]
    assert as_lists(one.select(NONE)) == []


def test_weights_of_multipliers_are_what_is_not_zero():
    multipliers = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 3.0]])
    assert as_lists(Weights.of(multipliers)) == [[(1, 2.0)], [], [(0, 1.0), (2, 3.0)]]
    assert as_lists(Weights.of(np.zeros((0, 3)))) == []


@pytest.mark.parametrize("seed", range(8))
def test_hulls_are_polygons_or_none(seed):
    rng = np.random.default_rng(seed)
    (one, its), (other, others) = random_hulls(rng, 7), random_hulls(rng, int(rng.integers(0, 5)))
    assert corners_of(one) == corners_put_in(its)
    assert one.known.tolist() == [polygon is not None for polygon in its]
    assert one.areas == pytest.approx([0.0 if polygon is None else polygon.area for polygon in its])
    for k, polygon in enumerate(its):
        assert (one[k] is None) == (polygon is None)
        assert polygon is None or one[k].vertices.tolist() == polygon.vertices.tolist()
    assert corners_of(Hulls.concatenate([one, other, one])) == corners_put_in(its + others + its)
    index = rng.integers(0, 7, 12)
    assert corners_of(one.select(index)) == corners_put_in([its[k] for k in index])
    assert not Hulls.none(3).known.any()
    assert Hulls.none(3).areas.tolist() == [0.0] * 3


@pytest.mark.parametrize("seed", range(3))
def test_outlines_are_selected_and_joined_one_by_one(seed):
    one, other = walked(merged_team(seed)), walked(merged_team(seed + 1, robots=3))
    assert one.inner.known.any()
    index = np.random.default_rng(seed).integers(0, 5, 9)
    assert contents(one.select(index)) == [contents(one)[k] for k in index]
    assert contents(Outlines.concatenate([other, one, other])) == contents(other) + contents(one) + contents(other)
    assert contents(one.select(NONE)) == []


@pytest.mark.parametrize("seed", range(4))
def test_pieces_in_any_order_are_the_whole(seed):
    whole, robots = walked(merged_team(seed)), np.arange(5)
    apart = [(robots[k : k + 1], whole.select(robots[k : k + 1])) for k in robots]
    for order in (range(5), reversed(range(5)), np.random.default_rng(seed).permutation(5)):
        assert contents(in_order([apart[k] for k in order])) == contents(whole)
    some = np.array([3, 0, 4])
    assert contents(in_order([(some, whole.select(some)), *apart[1:3]])) == contents(whole)


def test_a_piece_without_edges_gives_way_to_another_of_the_same_robot():
    polytope = merged_team(1)
    whole, robots = walked(polytope), np.arange(5)
    empty = whole.select(NONE)
    glance = Outlines.at_a_glance(polytope.of_robots(np.array([2])), len(polytope.constraints), "time")
    apart = [(robots[k : k + 1], whole.select(robots[k : k + 1])) for k in robots]
    found = in_order([apart[4], apart[0], (NONE, empty), (np.array([2]), glance), apart[1], apart[3]])
    assert found.reasons[2] == "time"
    assert found.outer.areas.tolist() == [*whole.outer.areas[:2], glance.outer.areas[0], *whole.outer.areas[3:]]


def test_at_a_glance_each_edge_is_its_row_or_a_side_of_the_box():
    polytope = merged_team(2)
    clipped, rows = polytope.of_robots(np.arange(5)), polytope.constraints
    found = Outlines.at_a_glance(clipped, len(rows))
    assert found.outer.areas.tolist() == clipped.polygons.areas.tolist()
    assert not found.inner.known.any()
    assert found.searches.tolist() == [0] * 5
    assert found.reasons == (None,) * 5
    for edge, (behind, claim) in enumerate(zip(clipped.behind.tolist(), as_lists(found.weights), strict=True)):
        assert claim == ([(behind, 1.0)] if behind < len(rows) else [])
        if behind < len(rows):
            assert (rows.i[behind], rows.j[behind]) == (WORLD, found.outer.owner[edge])
            assert rows.offset[behind] == found.outer.offsets[edge]
    assert any(found.weights.counts == 0)
    assert any(found.weights.counts == 1)


@pytest.mark.parametrize("projector", [everybody(), everybody(exact=False, solvers=("piqp",)), Projector(Window(1, 3), Stop())])
def test_what_is_projected_keeps_its_proofs(projector):
    polytope = merged_team(3)
    found = projector.robots(polytope).outlines
    rows, robots = polytope.constraints, np.arange(5)
    assert len(found.weights) == len(found.outer.offsets)
    assert (found.weights.counts > 1).any()
    assert (found.weights.weight > 0).all()
    assert max(excess(polytope, found, np.full(5, WORLD), robots)) <= 0
    for edge in np.flatnonzero(found.weights.counts == 0).tolist():
        side = np.concatenate([polytope.upper, -polytope.lower], axis=1)[found.outer.owner[edge]]
        normal = found.outer.normals[edge].tolist()
        assert found.outer.offsets[edge] == pytest.approx(side[[[1, 0], [0, 1], [-1, 0], [0, -1]].index(normal)])
    assert set(rows.j[found.weights.row]) <= set(robots)
