"""Range differences: the half-planes hold every place with such a difference, and little besides."""

import numpy as np
import pytest

from filter import Inconsistent, InvalidInput, Polygon, SetMembershipFilter, Team, position_from_range_difference

SQUARE = Polygon.box([-6, -5], [6, 5])


def slack(record, points):
    """Return (p,) how far inside of all half-planes points are; infinite where there is none."""
    return (record.offset - points @ record.normals.T).min(axis=1, initial=np.inf)


def differences(points, places):
    return np.hypot(*(points - places[0]).T) - np.hypot(*(points - places[1]).T)


def test_a_pair_is_of_measured_less_true():
    places, point = np.array([[-2.0, 1.0], [2.0, 0.5]]), np.array([[1.5, 2.5]])
    exact = float(differences(point, places)[0])
    long = position_from_range_difference(0.0, 0, places, exact + 0.3, [0.0, 0.3], SQUARE)
    assert slack(long, point)[0] >= -1e-13
    assert slack(position_from_range_difference(0.0, 0, places, exact + 0.3, [-0.3, 0.0], SQUARE), point)[0] < 0


def test_the_branch_turns_with_the_places():
    places = np.array([[-1.0, 0.0], [1.0, 0.0]])
    left = position_from_range_difference(0.0, 0, places, -1.0, 0.1, SQUARE)
    assert (slack(left, np.array([[-0.5, 0.0], [0.5, 0.0]])) >= 0).tolist() == [True, False]
    right = position_from_range_difference(0.0, 0, places[::-1], -1.0, 0.1, SQUARE)
    assert (slack(right, np.array([[-0.5, 0.0], [0.5, 0.0]])) >= 0).tolist() == [False, True]


def test_a_difference_that_any_place_has_says_nothing():
    record = position_from_range_difference(0.0, 0, [[-1, 0], [1, 0]], 0.0, 2.5, SQUARE)
    assert len(record.robot) == 0


@pytest.mark.parametrize(("value", "corner"), [(2.5, 3.0), (-2.5, 3.0), (1.9, -3.0), (0.0, -3.0), (0.0, 3.0)])
def test_what_no_place_has_is_a_conflict(value, corner):
    region = Polygon.box([corner, 0.5], [corner + 0.5, 1.0])
    filter_ = SetMembershipFilter(Team(1, arena=[[-9, -9], [9, 9]]))
    record = position_from_range_difference(0.0, 0, [[-1, 0], [1, 0]], value, 0.1, region)
    with pytest.raises(Inconsistent):
        filter_.update(filter_.start(0.0, [region]), [record])


def test_three_anchors_find_a_robot():
    anchors, truth = np.array([[-5.0, -4.0], [5.0, -4.0], [0.0, 4.5]]), np.array([[1.0, -0.5]])
    filter_ = SetMembershipFilter(Team(1, arena=[[-6, -5], [6, 5]]))
    belief = filter_.start(0.0, [SQUARE])
    for _ in range(3):
        pairs = [anchors[[0, 1]], anchors[[1, 2]], anchors[[2, 0]]]
        inside = belief.regions[0].outer
        told = [position_from_range_difference(0.0, 0, p, differences(truth, p)[0], 0.05, inside) for p in pairs]
        belief = filter_.update(belief, told)
    assert belief.regions[0].outer.contains(truth).all()
    assert belief.regions[0].outer.area < 0.05


@pytest.mark.parametrize(
    ("places", "bound"), [([[1, 1], [1, 1]], 0.1), ([1, 1], 0.1), ([[0, 0], [1, np.nan]], 0.1), ([[0, 0], [1, 1]], -0.1)]
)
def test_what_is_no_difference_is_refused(places, bound):
    with pytest.raises(InvalidInput):
        position_from_range_difference(0.0, 0, places, 0.1, bound, SQUARE)
