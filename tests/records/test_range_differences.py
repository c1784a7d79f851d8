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


def drawn(rng):
    """Return a polygon, two places and points in it: scales, flat polygons, points on the axis, at places and on the rim."""
    scale, shift = 10.0 ** rng.integers(-2, 4), rng.choice([0.0, 5e5]) * rng.normal(size=2)
    corners = rng.normal(size=(rng.integers(1, 9), 2)) * scale * rng.choice([1, 1e-3, 0], size=2, p=[0.7, 0.2, 0.1])
    polygon, places = Polygon.hull(corners + shift), rng.normal(size=(2, 2)) * scale * rng.choice([0.1, 1, 5]) + shift
    shares = rng.dirichlet(np.full(len(polygon.vertices), 0.3), size=40)
    return polygon, places, np.concatenate([shares @ polygon.vertices, polygon.vertices])


def test_every_place_with_such_a_difference_is_held():
    rng = np.random.default_rng(1)
    for _ in range(600):
        polygon, places, points = drawn(rng)
        exact, distance = differences(points, places), np.hypot(*(places[1] - places[0]))
        value = rng.choice([*exact, *(rng.choice([-1, 0, 1, 0.999, -0.999], 3) * distance)])
        bound = rng.choice([0, 1e-3, 0.1, 1]) * distance * rng.random()
        record = position_from_range_difference(0.0, 0, places, value, bound, polygon, rng.integers(2, 20))
        inside = np.abs(exact - value) <= bound
        assert (slack(record, points[inside]) >= -1e-14 * np.abs(points).max()).all()


@pytest.mark.parametrize("value", [-3.9, -2.0, -0.5, 0.0, 0.3, 2.0, 3.9, 4.0])
@pytest.mark.parametrize("bound", [0.0, 0.05, 0.6])
def test_little_is_left_besides(value, bound):
    places = np.array([[-1.5, 0.5], [2.2, -1.02]])
    grid = np.stack(np.meshgrid(np.linspace(-6, 6, 241), np.linspace(-5, 5, 201)), axis=-1).reshape(-1, 2)
    record = position_from_range_difference(0.0, 0, places, value, bound, SQUARE)
    held = Polygon.from_half_planes(record.normals, record.offset, *SQUARE.bounds)
    allowed = grid[np.abs(differences(grid, places) - value) <= bound + 0.05]  # neighbours on the grid differ by no more
    assert held.area <= 1.04 * Polygon.hull(allowed).area + 0.1


def test_the_half_planes_of_one_branch_are_near_its_hull():
    places = np.array([[-1.0, 0.0], [1.0, 0.0]])
    record = position_from_range_difference(0.0, 0, places, -1.0, 0.0, SQUARE)
    y = np.linspace(-5, 5, 4001)
    branch = np.stack([-np.sqrt(0.25 * (1 + y**2 / 0.75)), y], axis=1)
    held = Polygon.from_half_planes(record.normals, record.offset, *SQUARE.bounds)
    assert Polygon.hull(branch).area <= held.area <= 1.02 * Polygon.hull(branch).area


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
