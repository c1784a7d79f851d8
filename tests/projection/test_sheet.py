"""Windows on a sheet: what each of them is alone, end to end, however they are split."""

import numpy as np
import pytest
from helpers.programs import every_pair, links_of, merged_team, random_polytope, single, with_strangers

from filter.linear.constraints import WORLD
from filter.projection.sheet import Task, blank
from filter.projection.stop import Stop
from filter.projection.walk import project_some


def task_of(polytope, inside=True, stop=None, hops=99, most=99):
    box = polytope.lower, polytope.upper
    goal = (stop or Stop()).goal
    return Task(hops, most, inside, goal, links_of(polytope), polytope.constraints.rows, box)


def written(polytope, task, i, j):
    """Return a sheet with some windows, every number that nobody writes a strange one."""
    begin, end = polytope.constraints.groups(i, j)
    sheet = blank(end - begin, task)
    for column in (sheet.normals, sheet.offsets, sheet.vertices, sheet.weight, sheet.corners):
        column[:] = np.nan
    assert project_some((i, j), (begin, end), polytope.around(i, j), task, sheet) == 0
    return sheet


def piece(sheet, k):
    edges, corners = slice(*sheet.first[k : k + 2]), slice(*sheet.corner_first[k : k + 2])
    claims = slice(sheet.row_first[edges.start], sheet.row_first[edges.stop])
    columns = sheet.normals[edges], sheet.offsets[edges], sheet.vertices[edges], sheet.row[claims], sheet.weight[claims]
    first = sheet.row_first[edges.start : edges.stop + 1] - sheet.row_first[edges.start]
    return [column.tolist() for column in (*columns, first, sheet.corners[corners])]


def alone(polytope, task, i, j):
    return written(polytope, task, np.array([i]), np.array([j]))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["robots", "pairs", "small windows"])
def test_each_is_what_it_is_alone(seed, kind):
    polytope = merged_team(seed)
    i, j = every_pair(5) if kind == "pairs" else (np.full(5, WORLD), np.array([3, 0, 4, 1, 2]))
    task = task_of(polytope, kind == "robots", hops=1 if kind == "small windows" else 99, most=3)
    sheet = written(polytope, task, i, j)
    for k in range(len(j)):
        one = alone(polytope, task, i[k], j[k])
        assert piece(sheet, k) == piece(one, 0)
        assert (sheet.margin[k], sheet.searches[k], sheet.why[k]) == (one.margin[0], one.searches[0], one.why[0])
    assert np.isfinite(sheet.weight[: sheet.row_first[sheet.first[-1]]]).all()
    halves = [written(polytope, task, i[some], j[some]) for some in (slice(0, 2), slice(2, None))]
    both = [piece(half, k) for half, count in zip(halves, (2, len(j) - 2), strict=True) for k in range(count)]
    assert both == [piece(sheet, k) for k in range(len(j))]


def test_one_that_is_lost_has_no_edges():
    polytope = with_strangers(merged_team(1), [1, 4])
    robots = np.arange(7)
    sheet = written(polytope, task_of(polytope), np.full(7, WORLD), robots)
    assert np.flatnonzero(np.diff(sheet.first) == 0).tolist() == [1, 4]
    assert np.flatnonzero(np.diff(sheet.corner_first) == 0).tolist() == [1, 4]
    for k in range(7):
        assert piece(sheet, k) == piece(alone(polytope, task_of(polytope), WORLD, k), 0)


def test_one_that_is_empty_begins_the_sheet_with_its_proof():
    polytope = single([[0.6, 0.8], [-0.6, -0.8]], [0.5, -0.7], [0, 0], [1, 1])
    task = task_of(polytope)
    i, j = np.array([WORLD]), np.array([0])
    sheet = blank(np.array([2]), task)
    count = project_some((i, j), polytope.constraints.groups(i, j), polytope.around(i, j), task, sheet)
    assert count == 2
    multipliers = np.zeros(2)
    multipliers[sheet.row[:count]] = sheet.weight[:count]
    assert polytope.program().proves_empty(multipliers)


@pytest.mark.parametrize("stop", [Stop(1.0, searches=10**9), Stop(searches=4)])
@pytest.mark.parametrize("seed", range(4))
def test_there_is_room_enough(seed, stop):
    """Numba looks at no ends of arrays: the greatest numbers that are written must be within them."""
    rng = np.random.default_rng(seed)
    polytope = random_polytope(rng, int(rng.integers(1, 8)), int(rng.integers(0, 150)))
    robots = len(polytope.lower)
    for task in (task_of(polytope, stop=stop), task_of(polytope, stop=stop, most=2)):
        i, j = np.full(robots, WORLD), np.arange(robots)
        begin, end = polytope.constraints.groups(i, j)
        sheet, ample = blank(end - begin, task), blank(end - begin + 1000, task)
        assert project_some((i, j), (begin, end), polytope.around(i, j), task, ample) == 0
        assert (np.diff(ample.first) > 0).all()
        edges = ample.first[-1]
        assert edges <= len(sheet.offsets) == len(sheet.row_first) - 1
        assert ample.row_first[edges] <= len(sheet.row) == len(sheet.weight)
        assert ample.corner_first[-1] <= len(sheet.corners)
        assert len(blank(end - begin, task._replace(inside=False)).corners) == 0
