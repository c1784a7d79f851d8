"""A filter that takes more along: what it adds is implied, and what it finds is no larger."""

import numpy as np
import pytest
from worlds import World, escapes, unit

from experiments.remembering import CORNERS, RememberingFilter, between
from filter.polygon import Polygon
from filter.set_membership import SetMembershipFilter

WAYS = [{"pairs": True}, {"corners": True}, {"pairs": True, "corners": True}]
ROOM = {"rows_per_robot": 40, "rows_per_pair": 40}


def beliefs(estimator, seed, count=6, errors="uniform"):
    world = World(np.random.default_rng(seed), robots=3, errors=errors)
    estimator = estimator(world.team)
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    for motion, records in world.steps(count):
        predicted = estimator.predict(belief, motion.time, motion)
        belief = estimator.update(predicted, records)
        assert escapes(predicted, world.positions, world.headings) == []
        assert escapes(belief, world.positions, world.headings) == []
        yield belief


def test_a_filter_that_takes_nothing_more_along_is_the_filter():
    pairs = zip(beliefs(SetMembershipFilter, 0), beliefs(RememberingFilter, 0), strict=True)
    assert all((one.constraints.offset == other.constraints.offset).all() for one, other in pairs)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(2))
def test_who_takes_more_along_finds_regions_no_larger(seed, way):
    *_, less = beliefs(lambda team: SetMembershipFilter(team, **ROOM), seed, errors="extreme" if seed else "uniform")
    *_, more = beliefs(lambda team: RememberingFilter(team, **ROOM, **way), seed, errors="extreme" if seed else "uniform")
    for mine, theirs in zip(more.regions, less.regions, strict=True):
        assert mine.outer.area <= theirs.outer.area * 1.002 + 1e-12


@pytest.mark.parametrize("way", WAYS)
def test_what_is_added_says_nothing_new_of_where_the_team_is(way):
    *_, belief = beliefs(SetMembershipFilter, 1)
    estimator = RememberingFilter(World(np.random.default_rng(1), robots=3).team, **ROOM, **way)
    more = estimator._with_implied(belief)
    assert len(more.constraints) > len(belief.constraints)
    assert more.constraints.source.max() < len(more.sources)
    for mine, theirs in zip(estimator.update(more).regions, estimator.update(belief).regions, strict=True):
        assert mine.outer.area == pytest.approx(theirs.outer.area, rel=5e-3)


@pytest.mark.parametrize("corners", [[[0, 0], [1, 0], [0, 1]], [[0, 0], [3, 0]], [[1, 1]], unit(np.arange(40) / 40 * 6.28)])
def test_no_turn_between_normals_is_great(corners):
    normals = Polygon.hull(np.array(corners, dtype=float)).normals
    every = np.concatenate([normals, between(normals)])
    angles = np.sort(np.arctan2(*every.T[::-1]))
    assert np.hypot(*every.T) == pytest.approx(1)
    assert np.diff(np.append(angles, angles[0] + 2 * np.pi)).max() <= CORNERS + 1e-9
