"""Outlines of a team: taken apart and put together again, and the same from a glance, from windows and from the team."""

import numpy as np
import pytest
from helpers.worlds import of_robot
from projection.test_team import merged, team_regions

from filter.projection.claims import Outlines, in_order
from filter.projection.stop import Stop
from filter.projection.team import project_windows
from filter.projection.walk import PROVED
from filter.projection.window import Window


def same(one, other):
    """Return whether two outlines are the same to the last bit."""
    arrays = ("behind", "row", "multiplier", "row_first", "searches")
    polygons = ("normals", "offsets", "vertices", "margin", "first")
    return (
        all(getattr(one, name).tolist() == getattr(other, name).tolist() for name in arrays)
        and all(getattr(one.outer, name).tolist() == getattr(other.outer, name).tolist() for name in polygons)
        and one.reasons == other.reasons
    )


def pieces(polytope):
    walked = project_windows(polytope, Window(1, 3), ["exact"], Stop()).outlines
    robots = np.arange(len(polytope.lower))
    return [(robots[k : k + 1], walked.select(robots[k : k + 1])) for k in robots], walked


@pytest.mark.parametrize("seed", range(4))
def test_pieces_in_any_order_are_the_whole(seed):
    apart, whole = pieces(merged(seed))
    for order in (range(5), reversed(range(5)), np.random.default_rng(seed).permutation(5)):
        assert same(in_order([apart[k] for k in order]), whole)


def test_a_piece_without_edges_gives_way_to_another_of_the_same_robot():
    polytope = merged(1)
    apart, whole = pieces(polytope)
    empty = whole.select(np.zeros(0, dtype=int))
    glance = Outlines.at_a_glance(polytope.of_robots(np.array([2])), "time")
    found = in_order([apart[4], apart[0], (np.zeros(0, dtype=int), empty), (np.array([2]), glance), apart[1], apart[3]])
    assert found.reasons[2] == "time"
    assert found.outer.areas.tolist() == [*whole.outer.areas[:2], glance.outer.areas[0], *whole.outer.areas[3:]]


def test_at_a_glance_each_edge_is_its_row_or_a_side_of_the_box():
    polytope = merged(2)
    found = Outlines.at_a_glance(polytope.of_robots(np.arange(5)))
    rows = polytope.constraints
    for robot in range(5):
        assert found.outer.areas[robot] == of_robot(polytope, robot)[0].area
    for edge, behind in enumerate(found.behind.tolist()):
        claims = found.row[found.row_first[edge] : found.row_first[edge + 1]].tolist()
        assert claims == ([behind] if behind >= 0 else [])
        if behind >= 0:
            assert (rows.i[behind], rows.j[behind]) == (-1, found.outer.owner[edge])


def test_projections_of_the_team_keep_their_proofs():
    polytope = merged(3)
    projections = team_regions(polytope)
    found = Outlines.of(polytope, np.arange(5), projections)
    assert found.outer.areas.tolist() == [each.outer.area for each in projections]
    assert (found.behind == PROVED).any()
    claims = np.diff(found.row_first)
    assert (claims[found.behind == PROVED] >= 1).all()
    assert (claims[found.behind >= 0] == 1).all()
    assert (claims[(found.behind < 0) & (found.behind != PROVED)] == 0).all()
    assert (found.multiplier > 0).all()
