import json
from dataclasses import replace

import numpy as np
import pytest

from experiments.following.metrics import Metrics
from filter import Bearing, Compass, Frame, Position, Truth
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.angles import AngularIntervals
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.projection.claims import Hulls
from filter.sets.regions import Regions
from filter.team import Team

TEAM = Team(2)


def square(middle, half=1.0):
    return Polygon.box(np.asarray(middle, dtype=float) - half, np.asarray(middle, dtype=float) + half)


def belief_of(outers, inners=(None, None), searches=(0, 0), headings=None):
    """A belief with regions as wanted; everything else from a filter that has just started."""
    start = SetMembershipFilter(TEAM).start(0.0, outers, headings)
    edges = sum(len(outer.offsets) for outer in outers)
    causes = np.zeros(0, dtype=int), np.zeros(edges + 1, dtype=int)
    regions = Regions(Polygons.of(outers), Hulls.of(inners), np.array(searches), (None,) * len(outers), *causes)
    return replace(start, found=regions)


def frame_of(positions, headings=(0.0, 0.0), measurements=()):
    return Frame(0.0, None, measurements, Truth(np.array(positions, dtype=float), np.array(headings)))


APART = [square((0, 0)), square((5, 0))]


def test_a_team_inside_its_polygons_makes_checks_and_no_escape():
    metrics = Metrics()
    assert not metrics.add(frame_of([[0, 0.5], [5, 0]]), belief_of(APART), 0.01)
    assert (metrics.checks, metrics.escapes, metrics.heading_checks, metrics.heading_escapes) == (2, 0, 2, 0)
    assert not metrics.broken


def test_a_robot_outside_its_polygon_is_an_escape_and_is_named():
    metrics = Metrics()
    escapes = metrics.add(frame_of([[0, 0], [3.999, 0]]), belief_of(APART), 0.01)
    assert escapes
    assert (escapes.positions, escapes.headings) == ((1,), ())
    assert (metrics.checks, metrics.escapes, metrics.heading_escapes) == (2, 1, 0)
    assert metrics.broken


def test_a_robot_inside_another_ones_polygon_is_an_escape():
    assert Metrics().add(frame_of([[5, 0], [0, 0]]), belief_of(APART), 0.01).positions == (0, 1)


def test_a_robot_on_the_edge_is_inside():
    assert not Metrics().add(frame_of([[1, 1], [4, -1]]), belief_of(APART), 0.01)


def test_a_heading_outside_its_interval_is_an_escape_even_across_the_seam():
    metrics = Metrics()
    belief = belief_of(APART, headings=AngularIntervals([np.pi - 0.05, 0.0], [0.1, 0.1]))
    escapes = metrics.add(frame_of([[0, 0], [5, 0]], (-np.pi + 0.02, 0.2)), belief, 0.01)
    assert (escapes.positions, escapes.headings) == ((), (1,))
    assert (metrics.heading_checks, metrics.heading_escapes) == (2, 1)
    assert metrics.broken


def test_a_frame_without_truth_makes_no_check():
    metrics = Metrics()
    assert not metrics.add(Frame(0.0, None, (), None), belief_of(APART), 0.01)
    summary = metrics.summary()
    assert (summary["checks"], summary["heading_checks"], summary["point_rmse_m"]) == (0, 0, None)
    assert summary["outer_area_mean_m2"] == 4.0


def test_an_escape_is_never_forgotten():
    metrics = Metrics()
    metrics.add(frame_of([[9, 9], [5, 0]]), belief_of(APART), 0.01)
    metrics.add(frame_of([[0, 0], [5, 0]]), belief_of(APART), 0.01)
    assert metrics.broken
    assert (metrics.checks, metrics.escapes) == (4, 1)


def test_areas_ratios_and_searches_are_over_all_robots_and_steps():
    metrics = Metrics()
    inner = square((0, 0), 0.5)
    metrics.add(frame_of([[0, 0], [5, 0]]), belief_of(APART, (inner, None), (8, 3)), 0.01)
    metrics.add(frame_of([[0, 0], [5, 0]]), belief_of([square((0, 0), 2), APART[1]], (inner, APART[1]), (5, 4)), 0.01)
    summary = metrics.summary()
    assert summary["outer_area_mean_m2"] == pytest.approx((4 + 4 + 16 + 4) / 4)
    assert summary["outer_area_p95_m2"] == pytest.approx(np.quantile([4, 4, 16, 4], 0.95), rel=1e-5)
    assert summary["performance_ratio_mean"] == pytest.approx((1 / 4 + 0 + 1 / 16 + 1) / 4)
    assert summary["performance_ratio_min"] == 0.0
    assert summary["searches_mean"] == 5.0


def test_point_errors_are_from_the_centroids():
    metrics = Metrics()
    metrics.add(frame_of([[0.3, 0.4], [5, 0]]), belief_of(APART), 0.01)
    assert metrics.summary()["point_rmse_m"] == pytest.approx(np.sqrt(0.25 / 2), rel=1e-5)


def test_measurements_are_counted_one_by_one():
    metrics = Metrics()
    records = (Compass(0.0, [0, 1], [0.0, 0.0], 0.1), Bearing(0.0, [0], [1], [0.0], 0.1))
    metrics.add(frame_of([[0, 0], [5, 0]], measurements=records), belief_of(APART), 0.01)
    metrics.add(frame_of([[0, 0], [5, 0]], measurements=records[:1]), belief_of(APART), 0.01)
    assert metrics.summary()["measurements"] == 5


def test_rows_are_the_most_of_any_step():
    metrics = Metrics()
    belief = belief_of(APART)
    fewer = replace(belief, polytope=belief.polytope.with_constraints(belief.constraints.select(np.arange(3))))
    for known in (fewer, belief, fewer):
        metrics.add(frame_of([[0, 0], [5, 0]]), known, 0.01)
    assert metrics.summary()["rows_max"] == len(belief.constraints) == 8


def test_step_times_are_in_milliseconds():
    metrics = Metrics()
    for seconds in (0.010, 0.020, 0.090):
        metrics.add(frame_of([[0, 0], [5, 0]]), belief_of(APART), seconds)
    assert metrics.summary()["step_median_ms"] == pytest.approx(20.0)
    assert metrics.summary()["step_p95_ms"] == pytest.approx(83.0)


def test_a_run_of_nothing_has_a_summary_of_nothing():
    summary = Metrics().summary()
    assert summary["checks"] == 0
    assert summary["outer_area_mean_m2"] is None
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_a_summary_is_flat_json():
    metrics = Metrics()
    metrics.add(frame_of([[0, 0], [5, 0]]), belief_of(APART, APART), 0.01)
    summary = metrics.summary()
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    told = {"guarantee_suspended_because", "guarantee_suspended_since_s", "put_aside"}
    assert all(isinstance(value, int | float) for name, value in summary.items() if name not in told)
    assert (summary["guarantee_in_force"], summary["guarantee_suspended_since_s"]) == (True, None)


def test_an_escape_while_the_guarantee_is_suspended_breaks_no_promise_and_the_summary_says_why():
    metrics, doubted = Metrics(), replace(belief_of(APART), guarantee=Guarantee(np.array([3.0, np.inf]), ("a lie", "")))
    metrics.add(frame_of([[9, 0], [5, 0]]), doubted, 0.01)
    assert (metrics.escapes, metrics.broken) == (1, False)
    metrics.add(frame_of([[9, 0], [9, 0]]), doubted, 0.01)
    assert (metrics.escapes, metrics.escapes_in_force, metrics.broken) == (3, 1, True)
    metrics.add(frame_of([[0, 0], [5, 0]]), belief_of(APART), 0.01)
    summary = metrics.summary()
    assert (summary["guarantee_in_force"], summary["guarantee_suspended_since_s"]) == (False, 3.0)
    assert summary["guarantee_suspended_because"] == "suspended for robot 0 since 3.000 s, as a lie"


def test_where_nothing_is_known_from_inside_there_is_no_ratio():
    metrics = Metrics()
    metrics.add(frame_of([[0, 0], [5, 0]]), belief_of(APART), 0.01)
    assert metrics.summary()["performance_ratio_mean"] is None
    assert metrics.summary()["performance_ratio_min"] is None


def test_of_a_robot_that_is_away_nothing_is_checked_and_nothing_counted():
    metrics, belief = Metrics(), belief_of(APART)
    metrics.add(frame_of([[9, 0], [90, 0]], (0.0, 3.0)), replace(belief, guarantee=belief.guarantee.without(1)), 0.01)
    assert (metrics.checks, metrics.escapes, metrics.heading_checks, metrics.suspended) == (1, 1, 1, None)
    assert metrics.summary()["outer_area_mean_m2"] == 4.0
    assert metrics.summary()["point_rmse_m"] == 9.0


def test_a_position_is_one_measurement_of_a_robot_however_many_sides_it_has():
    metrics = Metrics()
    records = [Position.fix(0.0, 1, [5, 0], 1), Position.disc(0.0, 0, [0, 0], 1, 32), Compass(0.0, [0, 1], 0.0, 0.1)]
    metrics.add(frame_of([[0, 0], [5, 0]], measurements=records), belief_of(APART), 0.01)
    assert metrics.measurements == 4
