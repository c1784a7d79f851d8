"""What climbing finds is possible, and nearly all that is: held against the exact judge, and against places drawn at random."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.beacons.hulls import is_within

from experiments.beacons import climbing
from experiments.beacons.arcs import area_of
from experiments.beacons.climbing import Distances, at_most, reached
from experiments.beacons.outcomes import followed, judged, rings_of
from experiments.beacons.rings import exact_hull
from experiments.beacons.scenes import alone, team_that_stands
from filter import SetMembershipFilter


@pytest.mark.parametrize("seed", range(8))  # the first one is at a side of the arena
def test_for_one_robot_it_is_inside_the_exact_hull_and_nearly_all_of_it(seed):
    scene = alone(np.random.default_rng(seed), 5, 0.1)
    exact = exact_hull(rings_of(scene), scene.team.arena)
    found = reached(Distances.of(scene), scene.frames[0].truth.positions, 0)
    assert is_within(exact.around, found, 1e-9).all()
    assert 0.97 * exact.least <= area_of(found) <= exact.most


@pytest.mark.parametrize("seed", range(3))
def test_configurations_of_a_team_that_hold_are_in_the_filters_regions_and_hardly_farther_out(seed):
    scene = team_that_stands(np.random.default_rng(seed), 0.1)
    outcome = followed(SetMembershipFilter(scene.team), scene)
    distances, places = Distances.of(scene), scene.frames[0].truth.positions
    assert distances.hold(places)
    first = SetMembershipFilter(scene.team)
    belief = first.update(first.predict(first.start(0.0, scene.initial), 1.0), scene.frames[0].measurements)
    for robot, region in enumerate(belief.regions):
        assert region.outer.contains(reached(distances, places, robot)).all()
    rng = np.random.default_rng(seed)
    drawn = places + rng.uniform(-0.06, 0.06, (20_000, *places.shape))
    hold = np.array([each for each in drawn if distances.hold(each)])
    for robot in range(4):
        inside = is_within(reached(distances, places, robot), hold[:, robot], 0.005)
        assert inside.mean() > 0.99
    ratios = at_most(outcome).ratios
    assert (ratios >= 1).all()
    assert (ratios < 1.15).all()


def test_the_slope_is_that_of_the_slack():
    scene = team_that_stands(np.random.default_rng(0), 0.1)
    distances, at = Distances.of(scene), scene.frames[0].truth.positions.ravel()
    step = 1e-6
    for k in range(len(at)):
        change = np.zeros(len(at))
        change[k] = step
        difference = (distances.slack(at + change) - distances.slack(at - change)) / (2 * step)
        assert distances.slope(at)[:, k] == pytest.approx(difference, abs=1e-6)


def test_a_range_that_does_not_hold_is_noticed():
    scene = team_that_stands(np.random.default_rng(1), 0.1)
    distances, places = Distances.of(scene), scene.frames[0].truth.positions
    assert not distances.hold(places + np.array([[0.3, 0], [0, 0], [0, 0], [0, 0]]))
    assert (distances.slack(places.ravel()) >= 0).all() == distances.hold(places)


def test_a_climber_that_leaves_what_is_possible_is_not_believed(monkeypatch):
    scene = team_that_stands(np.random.default_rng(1), 0.1)
    distances, places = Distances.of(scene), scene.frames[0].truth.positions
    monkeypatch.setattr(climbing, "_climbed", lambda _, start, robot, angle: start + 0.5)
    assert reached(distances, places, 2).tolist() == [places[2].tolist()]
    assert np.isinf(at_most(followed(SetMembershipFilter(scene.team), scene)).ratios).all()


def test_outside_the_arena_nobody_is():
    scene = alone(np.random.default_rng(0), 3, 0.1)
    distances = replace(Distances.of(scene), least=np.zeros(3), greatest=np.full(3, 99.0))
    assert distances.hold(scene.team.arena[:1])
    assert not distances.hold(scene.team.arena[1:] + 1e-9)


def test_one_robot_alone_is_judged_alike_by_both():
    scene = alone(np.random.default_rng(3), 4, 0.1)
    outcome = followed(SetMembershipFilter(scene.team), scene)
    assert at_most(outcome).ratios[0] == pytest.approx(judged(outcome).ratio, rel=0.03)
    assert at_most(outcome).ratios[0] >= judged(outcome).ratio * (1 - 1e-3)
