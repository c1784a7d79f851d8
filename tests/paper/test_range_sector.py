"""The approximation of a range and bearing: the paper's area formula against polygons, and what more tangents give."""

import numpy as np
import pytest
import shapely

from experiments.paper.range_sector import least_overestimate, overestimate, polygon_area, polygon_of_rows, sector_area
from filter import Bearing, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.projection.stop import Stop
from filter.sensing.rows import TANGENT_SPACING
from filter.team import Team

# The filter widens every bearing and range by 1e-8; a share of a thin area is more than that.
WIDENED = 1e-5
CASES = [(0.02, 3.0), (0.05, 5.0), (0.05, 10.0), (0.1, 5.0), (0.1, 10.0), (0.3, 40.0)]


def papers_formula(least, greatest, half):
    """As printed in section 3."""
    return (greatest**2 * np.tan(half) - least**2 * np.sin(half) * np.cos(half)) / ((greatest**2 - least**2) * half)


def sector(range_error, half):
    turn = np.linspace(-half, half, 4001)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return shapely.Polygon(np.concatenate([(1 + range_error) * circle, (1 - range_error) * circle[::-1]]))


@pytest.mark.parametrize(("range_error", "degrees"), CASES)
def test_the_papers_formula_is_the_ratio_of_the_areas(range_error, degrees):
    half = np.radians(degrees)
    ratio = polygon_of_rows(range_error, half).area / sector(range_error, half).area
    assert papers_formula(1 - range_error, 1 + range_error, half) == pytest.approx(ratio, rel=WIDENED)
    assert overestimate(range_error, half) == pytest.approx(ratio, rel=WIDENED)


@pytest.mark.parametrize("tangents", [1, 2, 3, 7])
@pytest.mark.parametrize(("range_error", "degrees"), CASES)
def test_polygons_of_several_tangents_have_the_area_that_is_said(range_error, degrees, tangents):
    half = np.radians(degrees)
    polygon = polygon_of_rows(range_error, half, tangents)
    assert len(polygon.normals) == 3 + tangents
    assert polygon.area == pytest.approx(polygon_area(1 - range_error, 1 + range_error, half, tangents), rel=WIDENED)
    assert shapely.Polygon(polygon.vertices).buffer(1e-7).contains(sector(range_error, half))
    assert sector_area(1 - range_error, 1 + range_error, half) == pytest.approx(sector(range_error, half).area, rel=1e-5)


@pytest.mark.parametrize(("range_error", "degrees"), CASES)
def test_more_tangents_come_down_to_the_hull(range_error, degrees):
    half = np.radians(degrees)
    shares = [float(overestimate(range_error, half, tangents)) for tangents in (1, 2, 3, 10, 1000)]
    least = float(least_overestimate(range_error, half))
    assert shares == sorted(shares, reverse=True)
    assert least < shares[-1] == pytest.approx(least, rel=1e-5)
    assert least == pytest.approx(sector(range_error, half).convex_hull.area / sector(range_error, half).area, rel=1e-5)


def test_several_percent_for_a_wide_range_of_measurements():
    """The paper's words; more where the range is sharp and the bearing is not."""
    assert overestimate(0.1, np.radians(5)) == pytest.approx(1.018, abs=1e-3)
    assert overestimate(0.05, np.radians(5)) == pytest.approx(1.037, abs=1e-3)
    assert overestimate(0.05, np.radians(10)) == pytest.approx(1.148, abs=1e-3)


def updated(spacing):
    stop = Stop(performance_ratio=1 - 1e-6, searches=40)
    team_filter = SetMembershipFilter.light(Team(2, speed_limit=0.0), stop=stop, tangent_spacing=spacing, cells=0)
    sets = [Polygon.box([0, 0], [0, 0]), Polygon.box([1, -1], [3, 2])]
    belief = team_filter.start(0.0, sets, AngularIntervals(np.zeros(2), np.zeros(2)))
    seen = [Bearing(0.0, 0, 1, 0.3, np.radians(12)), Range(0.0, 0, 1, 2.0, 0.02, 0.0)]
    return team_filter.update(belief, seen)


def test_a_filter_with_more_tangents_has_more_rows_and_a_smaller_region():
    wide, narrow = updated(TANGENT_SPACING), updated(np.radians(6.1))
    count = [int(((belief.constraints.i == 0) & (belief.constraints.j == 1)).sum()) for belief in (wide, narrow)]
    assert count == [4, 7]
    half = np.radians(12)
    for belief, tangents in ((wide, 1), (narrow, 4)):
        assert belief.regions[1].outer.area == pytest.approx(polygon_area(1.98, 2.02, half, tangents), rel=1e-3)


@pytest.mark.parametrize("wrong", [0.0, -1.0, 2.0, np.nan])
def test_a_spacing_out_of_its_range_is_refused(wrong):
    with pytest.raises(InvalidInput):
        SetMembershipFilter(Team(2), tangent_spacing=wrong)
