"""What is handed in is taken as what it means, and is the caller's own again afterwards."""

import pickle
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from helpers.wrong import snapshot

from filter import (
    Alignment,
    AngularIntervals,
    Bearing,
    Compass,
    ExtendedKalmanFilter,
    FixedLag,
    Frame,
    GaussianBelief,
    InvalidInput,
    NoiseModel,
    Odometry,
    OutOfRange,
    Polygon,
    Range,
    RobustFilter,
    SetMembershipFilter,
    Stop,
    Team,
    Tolerance,
    Truth,
    Window,
    watch,
)

TEAM = Team(2, [[3.0, 0.0], [0.0, 3.0]], 0.5, 1.5, [[-5, -5], [5, 5]])
BOX = Polygon.box([-1, -1], [1, 1])
FILTERS = [SetMembershipFilter(TEAM, threads=1), RobustFilter(TEAM), ExtendedKalmanFilter(TEAM)]
HALVES = [
    np.float64(0.5),
    np.float32(0.5),
    np.array(0.5),
    Decimal("0.5"),
    Fraction(1, 2),
    np.array(Decimal("0.5"), dtype=object),
]
ONES = [1, np.int8(1), np.uint64(1), np.array(1), np.array(1, dtype=np.int32)]
SQUARE = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]


def records(time):
    return [Compass(time, 0, 0.2, 0.1), Bearing(time, 0, [1, 2], 0.3, 0.4), Range(time, [0, 1], [2, 3], 3.0, 0.5, 0.0)]


@pytest.mark.parametrize("half", HALVES, ids=repr)
@pytest.mark.parametrize("own", FILTERS, ids=lambda own: type(own).__name__)
def test_every_time_becomes_a_float(own, half):
    belief = own.start(half, [BOX, BOX])
    motion = Odometry(half, Fraction(3, 2), [0, 1], 0, 0.1, 0, 0.1, 0, 0)
    later = own.update(own.predict(belief, Decimal("1.5"), motion), [Compass(np.float32(1.5), 0, 0, 0.1)])
    assert [belief.time, motion.start, motion.time, later.time] == [0.5, 0.5, 1.5, 1.5]
    assert {type(time) for time in (belief.time, motion.start, motion.time, later.time, Frame(half).time)} == {float}


@pytest.mark.parametrize("half", HALVES, ids=repr)
def test_every_option_that_is_a_number_becomes_a_float(half):
    team, stop = Team(1, (), half, half), Stop(half, half)
    kept = [
        team.speed_limit.item(),
        team.turn_rate_limit.item(),
        stop.performance_ratio,
        stop.area_gap,
        FixedLag(FILTERS[0], len, half).lag,
    ]
    kept += [Tolerance(1, half).window, Alignment(half).share, NoiseModel(half).compass]
    kept += [SetMembershipFilter(TEAM, tangent_spacing=half).tangent_spacing, ExtendedKalmanFilter(TEAM, gate=half).gate]
    assert kept == [0.5] * 10
    assert {type(value) for value in kept} == {float}


@pytest.mark.parametrize("one", ONES, ids=repr)
def test_every_option_that_is_a_count_becomes_an_int(one):
    sets = SetMembershipFilter(TEAM, rows_per_robot=4 * one, rows_per_pair=4 * one, pairs=one, threads=one)
    kept = [Team(one).robots, Tolerance(one).q, Window(one).hops]
    kept += [sets.rows_per_robot // 4, sets.rows_per_pair // 4, sets.pairs, sets.threads, Stop(searches=4 * one).searches // 4]
    assert kept == [1] * 8
    assert {type(value) for value in kept} == {int}


@pytest.mark.parametrize("own", FILTERS, ids=lambda own: type(own).__name__)
def test_a_clock_that_goes_on_in_place_changes_no_belief(own):
    clock = np.array(0.0)
    beliefs = [own.start(clock, [BOX, BOX])]
    for _ in range(3):
        clock += 0.1
        beliefs.append(own.update(own.predict(beliefs[-1], clock), records(clock)))
    assert [belief.time for belief in beliefs] == pytest.approx([0.0, 0.1, 0.2, 0.3])


# What is made of arrays, and good ones.
MADE = {
    Compass: (0.0, [0, 1], [0.1, 0.2], [0.1, 0.1]),
    Bearing: (0.0, [0, 1], [2, 3], [0.1, 0.2], [0.1, 0.1]),
    Range: (0.0, [0, 1], [2, 3], [1.0, 2.0], [0.1, 0.1], [0.0, 0.0]),
    Odometry: (0.0, 1.0, [0, 1], [0.1, 0.1], [0.1, 0.1], [0.1, 0.1], [0.1, 0.1], [0.1, 0.1], [0.1, 0.1]),
    Truth: ([[0.0, 0.0]], [0.0]),
    Team: (1, [[1.0, 2.0]], 1.0, 1.0, [[-1.0, -1.0], [1.0, 1.0]]),
    AngularIntervals: ([0.1, 0.2], [0.1, 0.1]),
    Polygon: (SQUARE, [1.0, 1.0, 1.0, 1.0], [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]),
    Polygon.box: ([0.0, 0.0], [1.0, 1.0]),
    Polygon.from_vertices: ([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],),
    Polygon.from_half_planes: (SQUARE, [1.0, 1.0, 1.0, 1.0], [-2.0, -2.0], [2.0, 2.0]),
    GaussianBelief: (0.0, [[0.0, 0.0, 0.0]], np.eye(3)),
}


@pytest.mark.parametrize("make", MADE, ids=lambda make: make.__qualname__)
def test_no_array_of_the_callers_is_kept_or_made_read_only(make):
    given = [np.array(value) for value in MADE[make]]
    made = make(*given)
    before = snapshot(made)
    for array in given:
        array[...] = array + 1
    assert snapshot(made) == before


@pytest.mark.parametrize("masked", [np.ma.array([0, 1], mask=[0, 1]), np.ma.array([0, 1]), [np.ma.array([0, 1])] * 2])
def test_a_masked_array_is_refused_with_what_to_do(masked):
    for call in (lambda: Compass(0, masked, 0, 0.1), lambda: Compass(0, 0, masked, 0.1), lambda: Team(2, masked)):
        with pytest.raises(InvalidInput, match=r"none of them masked \(fill or drop those\); came \[?masked_array"):
            call()


def test_no_list_of_the_callers_is_kept():
    solvers, said = ["piqp"], records(0.0)
    sets, frame = SetMembershipFilter(TEAM, solvers=solvers), Frame(0.0, None, said)
    solvers.append("nobody")
    said.clear()
    assert sets.solvers == ("piqp",)
    assert len(frame.measurements) == 3


@pytest.mark.parametrize("own", FILTERS, ids=lambda own: type(own).__name__)
def test_what_comes_from_a_generator_is_as_good_as_a_list(own):
    one = own.update(own.start(0, [BOX, BOX]), records(0.0))
    other = own.update(own.start(0, (box for box in [BOX, BOX])), (record for record in records(0.0)))
    assert snapshot(one) == snapshot(other)


@pytest.mark.parametrize("own", FILTERS, ids=lambda own: type(own).__name__)
def test_a_belief_about_other_bodies_is_refused(own):
    with pytest.raises(InvalidInput, match=r"a belief about 2 robots, .*; came one about 3"):
        own.update(type(own)(Team(3)).start(0, [BOX] * 3), [])


def test_a_way_longer_than_any_number_is_refused():
    for kind in (SetMembershipFilter, RobustFilter, ExtendedKalmanFilter):
        fast = kind(Team(1, speed_limit=1e60))
        with pytest.raises(InvalidInput, match="no farther than 1e"):
            fast.predict(fast.start(0, [BOX]), 1e60)


def test_the_kalman_filter_takes_exact_measurements_and_refuses_what_it_cannot_weigh():
    kalman = ExtendedKalmanFilter(TEAM)
    belief = kalman.start(0, [Polygon.box([0, 0], [0, 0])] * 2, AngularIntervals([0, 0], [0, 0]))
    exact = [Compass(0, [0, 1], 0, 0), Range(0, 0, 2, 3, 0, 0), Bearing(0, 0, [1, 2], 0, 0)]
    after = kalman.update(kalman.update(belief, exact), exact)
    assert np.isfinite(after.mean).all() and np.isfinite(after.covariance).all()
    with pytest.raises(InvalidInput, match="covariance: finite numbers"):
        kalman.predict(belief, 1.0, Odometry(0, 1, 0, 1e90, 1e90, 0, 1e90, 0, 0))


def test_places_and_angles_that_are_not_finite_are_in_nothing():
    belief = FILTERS[0].start(0, [BOX, BOX])
    assert BOX.contains([[np.nan, 0], [0, np.inf], [0, 0]]).tolist() == [False, False, True]
    assert belief.regions.contains([[0, 0], [np.nan, 0]]).tolist() == [True, False]
    assert belief.regions.contains([[-np.inf, 0], [0, 0]]).tolist() == [False, True]
    assert AngularIntervals.circles(2).contains([np.nan, np.inf]).tolist() == [False, False]


def test_arcs_and_regions_are_indexed_and_gone_through_as_lists():
    arcs, regions = AngularIntervals([0.0, 1.0, 2.0], 0.1), FILTERS[0].start(0, [BOX, BOX]).regions
    assert [arc.centre.tolist() for arc in arcs] == [[0.0], [1.0], [2.0]]
    assert [arcs[-1].centre[0], *arcs[np.array([2, 0])].centre, *arcs[1:].centre] == [2.0, 2.0, 0.0, 1.0, 2.0]
    assert len(list(regions)) == len(regions[:]) == len(regions.outer[0:9]) == 2
    for beyond in (lambda: arcs[3], lambda: regions[2], lambda: regions.outer[-3]):
        with pytest.raises(OutOfRange, match="among 0 to") as caught:
            beyond()
        assert isinstance(caught.value, IndexError) and isinstance(caught.value, InvalidInput)


def test_arcs_are_compared_one_by_one():
    with pytest.raises(InvalidInput, match="as many other arcs, 3; came 2 arcs"):
        AngularIntervals.circles(3).intersection(AngularIntervals.circles(2))


def test_an_ellipse_of_no_size_is_a_point():
    belief = FILTERS[0].start(0, [BOX, BOX])
    places, sizes = [[3.0, 0.0], [0.0, 0.0]], [np.eye(2), np.diag([1e-200, 1e90])]
    (alarm,) = watch(belief, places, sizes, 0.0)
    assert alarm.robot == 0 and alarm.everything and alarm.distance == pytest.approx(2.0)
    (tiny,) = watch(belief, places, np.array(sizes) * [[[1e-310]], [[1e-90]]])
    assert tiny.distance == pytest.approx(2.0) and tiny.normal.tolist() == [1.0, 0.0]


def test_a_belief_goes_through_a_pickle_unchanged():
    for own in FILTERS:
        belief = own.update(own.start(0, [BOX, BOX]), records(0.0))
        assert snapshot(pickle.loads(pickle.dumps(belief))) == snapshot(belief)
