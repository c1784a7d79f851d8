"""The regions of a team, one at a time and all at once."""

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.teams import begun
from helpers.worlds import World

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.linear.polytope import Polytope
from filter.projection.claims import Hulls, Outlines
from filter.projection.window import Window
from filter.sets.regions import Regions


@pytest.mark.parametrize("scope", [Window.everybody(), Window()])
def test_one_region_is_what_the_arrays_say(scope):
    world = World(np.random.default_rng(4), robots=4)
    estimator = SetMembershipFilter(world.team, scope=scope)
    regions = estimator.update(begun(estimator, world), world.measure()).regions
    assert len(list(regions)) == len(regions) == 4
    for robot, region in enumerate(regions):
        assert region.outer.area == regions.outer.areas[robot]
        assert (region.inner is None) == (not regions.inner.known[robot])
        assert region.inner is None or region.inner.area == pytest.approx(regions.inner.areas[robot])
        assert (region.searches, region.reason) == (regions.searches[robot], regions.reasons[robot])
        assert len(region.causes) == len(region.outer.offsets)
        assert all(len(causes) and (np.diff(causes) > 0).all() for causes in region.causes)
    assert regions[1:3][1].outer.area == regions[2].outer.area == regions[-2].outer.area
    assert regions.contains(world.positions).all()
    far = world.positions + np.array([[0, 0], [99, 0], [0, 0], [0, -99]])
    assert regions.contains(far).tolist() == [True, False, True, False]
    with pytest.raises(IndexError):
        regions[4]
    with pytest.raises(ValueError, match="read-only"):
        regions.searches[0] = 9


@pytest.mark.parametrize("scope", [Window.everybody(), Window()])
@pytest.mark.parametrize("seed", range(3))
def test_ratios_of_all_are_the_ratios_one_by_one(scope, seed):
    world = World(np.random.default_rng(seed), robots=4, errors="extreme" if seed else "uniform")
    estimator = SetMembershipFilter(world.team, scope=scope)
    belief = estimator.update(begun(estimator, world), world.measure())
    for regions in (belief.regions, estimator.predict(belief, 0.1).regions):
        assert regions.performance_ratios == pytest.approx([region.performance_ratio for region in regions])
    assert (belief.regions.performance_ratios > 0.1).any() == scope.leaves_nobody_out


def test_ratios_of_points_segments_and_of_what_nobody_knows():
    point, segment, box = Polygon.box([5, 5], [5, 5]), Polygon.from_vertices([[0, 0], [3, 1]]), Polygon.box([0, 0], [1, 1])
    thin = Polygon.box([0, 0], [1e3, 1e-3])
    cases = [
        (point, point),
        (point, None),
        (segment, segment),
        (box, point),
        (box, box),
        (thin, thin),
        (box, None),
        (thin, None),
    ]
    outer, inner = Polygons.of([outer for outer, _ in cases]), Hulls.of([inner for _, inner in cases])
    edges = len(outer.offsets)
    regions = Regions(outer, inner, np.zeros(8, dtype=int), (None,) * 8, np.zeros(edges, dtype=int), np.arange(edges + 1))
    assert regions.performance_ratios.tolist() == [region.performance_ratio for region in regions]
    assert regions.performance_ratios == pytest.approx([1, 0, 1, 0, 1, 1, 0, 0])


def test_at_a_glance_nothing_is_searched_and_each_edge_names_its_row_or_its_box():
    rows = on_robot(1, np.array([[1.0, 0.0]]), np.array([0.5]), np.array([7]))
    polytope = Polytope(rows, np.zeros((2, 2)), np.ones((2, 2)), np.array([3, 4]))
    regions = Regions.at_a_glance(polytope)
    assert [region.outer.area for region in regions] == pytest.approx([1.0, 0.5])
    assert all(region.searches == 0 and region.reason is None and region.inner is None for region in regions)
    assert [causes.tolist() for causes in regions[0].causes] == [[3]] * 4
    right = regions[1].outer.normals[:, 0].argmax()
    assert [causes.tolist() for causes in regions[1].causes] == [[7] if edge == right else [4] for edge in range(4)]


def test_causes_are_the_sources_of_the_rows_that_prove_an_edge():
    rows = on_robot(0, np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([0.5, 0.5]), np.array([9, 8]))
    polytope = Polytope(rows, np.zeros((1, 2)), np.ones((1, 2)))
    glance = Outlines.at_a_glance(polytope.of_robots(np.array([0])), 2)
    causes = Regions.of(polytope, glance)[0].causes  # nobody asks where the box comes from
    assert [each.tolist() for each in causes] == [[9], [8], [], []]
