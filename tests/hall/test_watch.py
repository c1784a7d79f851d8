import numpy as np
import pytest
from helpers.worlds import World
from scipy.stats import chi2
from shapely import Point, affinity
from shapely import Polygon as Shape

from filter import Belief, InvalidInput, Polygon, SetMembershipFilter, Team
from filter.watch import watch

RIM = 1e-6  # closer to touching than this, shapely's circle of segments is no oracle


def measured_belief(seed: int = 3) -> tuple[World, Belief]:
    world = World(np.random.default_rng(seed), robots=4)
    team_filter = SetMembershipFilter(world.team)
    return world, team_filter.update(team_filter.start(0.0, world.initial_sets()), world.measure())


def test_the_truth_raises_no_alarm():
    for seed in range(20):
        world, belief = measured_belief(seed)
        assert watch(belief, world.positions) == ()
        assert watch(belief, world.positions, np.tile(1e-12 * np.eye(2), (4, 1, 1))) == ()


def test_a_point_raises_an_alarm_just_when_it_is_outside_its_polygon():
    world, belief = measured_belief()
    generator = np.random.default_rng(0)
    for _ in range(200):
        points = world.positions + generator.normal(0, 0.2, world.positions.shape)
        inside = [bool(region.outer.contains(point)) for region, point in zip(belief.regions, points, strict=True)]
        alarms = watch(belief, points)
        assert [k for k in range(4) if not inside[k]] == [alarm.robot for alarm in alarms]
        assert not any(alarm.everything for alarm in alarms)


def test_a_whole_ellipse_is_impossible_just_when_it_misses_the_polygon():
    world, belief = measured_belief()
    generator, size = np.random.default_rng(1), np.sqrt(chi2.ppf(0.95, 2))
    seen = {True: 0, False: 0}
    for _ in range(200):
        points = world.positions + generator.normal(0, 0.4, world.positions.shape)
        roots = generator.normal(0, 0.05, (4, 2, 2))
        covariances = roots @ roots.transpose(0, 2, 1) + 1e-6 * np.eye(2)
        missed = {alarm.robot for alarm in watch(belief, points, covariances, 0.95) if alarm.everything}
        for robot, region in enumerate(belief.regions):
            root = np.linalg.cholesky(covariances[robot]) * size
            ellipse = affinity.affine_transform(Point(0, 0).buffer(1, 256), [*root.ravel(), *points[robot]])
            gap = ellipse.distance(Shape(region.outer.vertices))
            if gap > RIM or ellipse.intersection(Shape(region.outer.vertices)).area > RIM:
                seen[gap > 0] += 1
                assert (robot in missed) == (gap > 0)
    assert min(seen.values()) > 50


def test_an_alarm_carries_its_proof():
    world, belief = measured_belief()
    points = world.positions.copy()
    points[1] += [3.0, 0.0]
    (alarm,) = watch(belief, points, np.tile(0.01 * np.eye(2), (4, 1, 1)))
    assert alarm.robot == 1
    assert alarm.everything
    assert (belief.regions[1].outer.vertices @ alarm.normal <= alarm.offset).all()
    nearest_of_ellipse = alarm.normal @ points[1] - 0.1 * np.sqrt(chi2.ppf(0.997, 2))
    assert nearest_of_ellipse - alarm.offset == pytest.approx(alarm.distance, abs=1e-9)
    assert 1 <= len(alarm.edges) <= 2
    assert alarm.sources
    assert "impossible by" in str(alarm)


def test_a_centre_outside_with_an_ellipse_that_reaches_in_is_the_lesser_alarm():
    team_filter = SetMembershipFilter(Team(1))
    belief = team_filter.start(0.0, [Polygon.box([0, 0], [1, 1])])
    (alarm,) = watch(belief, [[1.1, 0.5]], [np.eye(2)])
    assert not alarm.everything
    assert alarm.distance == pytest.approx(0.1, abs=1e-9)
    np.testing.assert_allclose(alarm.normal, [1, 0], atol=1e-12)


def test_a_corner_names_both_its_edges():
    team_filter = SetMembershipFilter(Team(1))
    belief = team_filter.start(0.0, [Polygon.box([0, 0], [1, 1])])
    (alarm,) = watch(belief, [[2.0, 2.0]])
    assert len(alarm.edges) == 2
    normals = belief.regions[0].outer.normals[list(alarm.edges)]
    np.testing.assert_allclose(sorted(normals.tolist()), [[0, 1], [1, 0]])


@pytest.mark.parametrize(("x", "y", "away"), [(1.5, 0.5, 0.5), (1.3, 1.4, 0.5), (-3.0, 5.0, 5.0)])
@pytest.mark.parametrize("covariances", [None, [1e-4 * np.eye(2)]])
def test_an_estimate_of_another_time_is_impossible_just_when_it_is_farther_off_than_the_robot_can_get(x, y, away, covariances):
    belief = SetMembershipFilter(Team(1)).start(0.0, [Polygon.box([0, 0], [1, 1])])
    (alarm,) = watch(belief, [[x, y]], covariances, moved=away - 1e-3)
    assert alarm.distance == pytest.approx(1e-3, abs=1e-12)
    corners = belief.regions[0].outer.vertices
    assert (corners @ alarm.normal <= alarm.offset - (away - 1e-3)).all(), "the line is moved outward, too"
    assert alarm.edges == watch(belief, [[x, y]])[0].edges
    assert watch(belief, [[x, y]], covariances, moved=[away + 1e-9]) == ()


def test_a_whole_ellipse_is_beyond_what_has_moved_as_well():
    belief = SetMembershipFilter(Team(1)).start(0.0, [Polygon.box([0, 0], [1, 1])])
    reach = 0.1 * np.sqrt(chi2.ppf(0.997, 2))
    (near,), (far,) = (watch(belief, [[1.5 + reach + by, 0.5]], [0.01 * np.eye(2)], moved=0.5) for by in (-1e-3, 1e-3))
    assert (near.everything, far.everything) == (False, True)
    assert far.distance == pytest.approx(1e-3, abs=1e-9)


def test_nothing_is_said_of_a_robot_without_an_estimate():
    _, belief = measured_belief()
    assert watch(belief, np.full((4, 2), np.nan)) == ()


@pytest.mark.parametrize(
    ("positions", "covariances", "probability", "expected"),
    [
        (np.zeros((3, 2)), None, 0.9, "positions of 4 robots"),
        (np.zeros((4, 2)), np.zeros((4, 2, 2)), 0.9, "positive definite"),
        (np.zeros((4, 2)), np.zeros((2, 2)), 0.9, "covariances of 4 robots"),
        (np.zeros((4, 2)), None, 1.0, "probability"),
    ],
)
def test_what_does_not_fit_is_refused(positions, covariances, probability, expected):
    _, belief = measured_belief()
    with pytest.raises(InvalidInput, match=expected):
        watch(belief, positions, covariances, probability)


@pytest.mark.parametrize("moved", [-0.1, np.inf, np.zeros(3), np.zeros((4, 1)), "far"])
def test_a_way_that_does_not_fit_is_refused(moved):
    _, belief = measured_belief()
    with pytest.raises(InvalidInput, match="moved"):
        watch(belief, np.zeros((4, 2)), moved=moved)
