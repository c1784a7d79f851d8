"""What is left of the poses of robots, one after the other, with the others as sets; compiled."""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers, Mask, read_only
from filter.compiled import bounds_of, compiled, put
from filter.geometry.angles import intersection
from filter.geometry.convex import EPSILON, clip_box, hull_of, largest_of
from filter.poses.branch import FEW_EDGES, HULL_EDGES, Roots, Tree, branch
from filter.poses.cell import Said
from filter.poses.slices import COUNT, DIRECTIONS, regrouped

SIDES_OF_BOX = 4
CORNERS_FOR_OTHERS = FEW_EDGES + SIDES_OF_BOX  # of the set that a robot is for others


class Heard(NamedTuple):
    """What robots are told, see `cells.Told`: (m,) readings, and the ways from sensors to centres.

    Attributes:
        target: (m,) as in `Told`, as are begins, sector (m, 4) and own.
        apart: (p, 2) corners of by how much the way to the target is another one than what is measured [m].
        apart_first: (m + 1,) where those of each reading begin; none where it is the same.
        headings: (n,) centres and (n,) bounds [rad].
        spacing: Greatest angle between two tangents of a range's far side [rad].
    """

    target: Integers
    begins: Mask
    sector: Array
    own: Mask
    apart: Array
    apart_first: Integers
    headings: tuple[Array, Array]
    spacing: float


class Sets(NamedTuple):
    """Where bodies can be; those of robots become smaller as they are found.

    Attributes:
        corners: (b, CORNERS_FOR_OTHERS, 2) of the sets that bodies are for others [m].
        size: (b,) how many of these each has.
        margin: (1,) how far sets can reach beyond the hulls of their corners [m].
        box: (n, 2) lower and (n, 2) upper corners of robots' boxes [m].
    """

    corners: Array
    size: Integers
    margin: Array
    box: tuple[Array, Array]


class Starts(NamedTuple):
    """What k robots' poses are cut from.

    Attributes:
        robot: (k,)
        said: (k, 2) from where to where they are told something.
        lines: (e, 2) normals and (e,) offsets of polygons [m].
        vertices: (e, 2) of these.
        first: (k + 1,) where each polygon begins.
        slices: (s,) centres, (s,) bounds [rad] and (s, COUNT) supports [m] of slices.
        slice_first: (k + 1,) where those of each robot begin.
        is_taken: Whether those after it are cut by what is found of a robot, in place of what was known.
    """

    robot: Integers
    said: Integers
    lines: tuple[Array, Array]
    vertices: Array
    first: Integers
    slices: tuple[Array, Array, Array]
    slice_first: Integers
    is_taken: bool = True


class Outcome(NamedTuple):
    """What is found of k robots, with c cells each, to be filled.

    Attributes:
        trees: How they were split, k at a time: each of its arrays has one more axis, the first.
        rows: (k, HULL_EDGES, 4) normals and offsets [m], and whether they are among the few that are enough for others.
        edges: (k,) how many there are.
        heading: (k, 2) centre and bound of what is left of the heading [rad].
        slices: (k, g, 2 + COUNT) of what is left, see `regrouped`; g is how many there are at most.
        kept: (k,) how many there are.
    """

    trees: Tree
    rows: Array
    edges: Integers
    heading: Array
    slices: Array
    kept: Integers

    @classmethod
    def blank(cls, robots: int, cells: int, slices: int) -> "Outcome":
        """Return one to be filled."""
        child, rounds = np.zeros((2, robots, 2 * cells), dtype=np.int64)
        root, arcs, reach = np.full((robots, cells), -1), np.zeros((robots, cells, 2)), np.zeros((robots, cells, COUNT))
        trees = Tree(np.zeros((robots, 2 * cells, 3)), child, rounds, root, arcs, reach)
        rows, heading = np.zeros((robots, HULL_EDGES, 4)), np.zeros((robots, 2))
        edges, kept = np.zeros((2, robots), dtype=np.int64)
        return cls(trees, rows, edges, heading, np.zeros((robots, slices, 2 + COUNT)), kept)

    def first(self, robots: int) -> "Outcome":
        """Return that of the first so many robots, for good."""
        trees = Tree(*(read_only(column[:robots]) for column in self.trees))
        return Outcome(trees, *(read_only(column[:robots]) for column in self[1:]))


@compiled
def in_turn(some: tuple[int, int], starts: Starts, heard: Heard, sets: Sets, found: Outcome) -> int:
    """Find the poses of some of k robots, from one to before another; return the first of which nothing is left, or -1."""
    for k in range(some[0], some[1]):
        roots, said = _roots(k, starts, heard, sets), _said(k, starts, heard, sets)
        robot = starts.robot[k]
        found.heading[k, 0], found.heading[k, 1] = heard.headings[0][robot], heard.headings[1][robot]
        if not len(roots.corners) or not _found(k, roots, said, sets.margin[0], found):
            return k
        if starts.is_taken:
            _take(robot, sets, found.rows[k, : found.edges[k]])
    return -1


@compiled
def _said(k: int, starts: Starts, heard: Heard, sets: Sets) -> Said:
    """Return what was said of a robot, with targets as its centre would see them."""
    begin, end = starts.said[k]
    targets, corners = 0, 0
    for m in range(begin, end):
        if heard.begins[m]:
            apart = heard.apart_first[m + 1] - heard.apart_first[m]
            targets, corners = targets + 1, corners + sets.size[heard.target[m]] * max(1, apart)
    first, point_first = np.zeros(targets + 1, dtype=np.int64), np.zeros(targets + 1, dtype=np.int64)
    points, count = np.empty((corners, 2)), 0
    for m in range(begin, end):
        if not heard.begins[m]:
            continue
        body, at = heard.target[m], point_first[count]
        apart = heard.apart[heard.apart_first[m] : heard.apart_first[m + 1]]
        places = sets.corners[body, : sets.size[body]]
        if len(apart):
            places = _sums(places, apart)
        for v in range(len(places)):
            points[at + v, 0], points[at + v, 1] = places[v, 0], places[v, 1]
        first[count], point_first[count + 1] = m - begin, at + len(places)
        count += 1
    first[count], points = end - begin, points[: point_first[count]].copy()
    return Said(heard.sector[begin:end], heard.own[begin:end], first, points, point_first, heard.spacing)


@compiled
def _sums(places: Array, apart: Array) -> Array:
    """Return the hull of the sums of points."""
    sums = np.empty((len(places) * len(apart), 2))
    for k in range(len(places)):
        for m in range(len(apart)):
            for axis in range(2):
                sums[k * len(apart) + m, axis] = places[k, axis] + apart[m, axis]
    return hull_of(sums)


@compiled
def _roots(k: int, starts: Starts, heard: Heard, sets: Sets) -> Roots:
    """Return the sets of poses of a robot: its polygon, cut by its slices if it has any, and its heading."""
    robot, begin, end = starts.robot[k], starts.first[k], starts.first[k + 1]
    centre, bound = heard.headings[0][robot], heard.headings[1][robot]
    one, count = starts.slice_first[k], starts.slice_first[k + 1] - starts.slice_first[k]
    if not count:
        arc = np.empty((1, 2))
        arc[0, 0], arc[0, 1] = centre, bound
        whole = np.zeros(2, dtype=np.int64)
        whole[1] = end - begin
        return Roots(starts.vertices[begin:end].copy(), whole, arc)
    own, lines = end - begin, end - begin + COUNT
    arcs, first = np.empty((count, 2)), np.zeros(count + 1, dtype=np.int64)
    corners, room = np.empty((count * (lines + SIDES_OF_BOX), 2)), np.empty(lines + SIDES_OF_BOX, dtype=np.int64)
    normals, offsets = np.empty((lines, 2)), np.empty(lines)
    for m in range(lines):
        for axis in range(2):
            normals[m, axis] = starts.lines[0][begin + m, axis] if m < own else DIRECTIONS[m - own, axis]
        offsets[m] = starts.lines[1][begin + m] if m < own else 0.0
    for m in range(count):
        each, at = one + m, first[m]
        arcs[m, 0], arcs[m, 1] = intersection(starts.slices[0][each], starts.slices[1][each], centre, bound)
        put(starts.slices[2][each], offsets[own:])
        size, margin = clip_box((corners[at:], room), (normals, offsets), sets.box[0][robot], sets.box[1][robot])
        sets.margin[0] = max(sets.margin[0], margin)
        first[m + 1] = at + (size if arcs[m, 1] >= 0 else 0)
    return Roots(corners[: first[count]].copy(), first, arcs)


@compiled
def _found(k: int, roots: Roots, said: Said, margin: float, found: Outcome) -> bool:
    """Write what is left of a robot's poses; return whether anything is."""
    (west, east), (south, north) = bounds_of(roots.corners[:, 0]), bounds_of(roots.corners[:, 1])
    x, y = (west + east) / 2, (south + north) / 2
    slack = 8 * EPSILON * (max(abs(x), abs(y)) + max(largest_of(roots.corners), largest_of(said.points)))
    for points in (roots.corners, said.points):
        for m in range(len(points)):
            points[m, 0], points[m, 1] = points[m, 0] - x, points[m, 1] - y
    trees = found.trees
    tree = Tree(trees.line[k], trees.child[k], trees.rounds[k], trees.root[k], trees.arcs[k], trees.reach[k])
    rows = branch(roots, found.heading[k], said, margin + slack, tree)
    for m in range(len(rows)):
        rows[m, 2] += rows[m, 0] * x + rows[m, 1] * y + slack
        put(rows[m], found.rows[k, m])
    for m in range(len(tree.line)):
        tree.line[m, 2] += tree.line[m, 0] * x + tree.line[m, 1] * y
    leaves = 0
    while leaves < len(tree.root) and tree.root[leaves] >= 0:
        for m in range(COUNT):
            tree.reach[leaves, m] += DIRECTIONS[m, 0] * x + DIRECTIONS[m, 1] * y + slack
        leaves += 1
    found.edges[k] = len(rows)
    if found.slices.shape[1] and len(rows):
        some = tree.root[:leaves], tree.arcs[:leaves], tree.reach[:leaves]
        slices = regrouped(found.heading[k], some, len(roots.heading), found.slices.shape[1])
        found.kept[k] = len(slices)
        for m in range(len(slices)):
            put(slices[m], found.slices[k, m])
    return len(rows) > 0


@compiled
def _take(robot: int, sets: Sets, rows: Array) -> None:
    """Take over where a robot was found to be, as the set that it is for others."""
    normals, offsets, count = np.empty((FEW_EDGES, 2)), np.empty(FEW_EDGES), 0
    for m in range(len(rows)):
        if rows[m, 3] > 0:
            normals[count, 0], normals[count, 1], offsets[count] = rows[m, 0], rows[m, 1], rows[m, 2]
            count += 1
    into = sets.corners[robot], np.empty(CORNERS_FOR_OTHERS, dtype=np.int64)
    lower, upper = sets.box[0][robot], sets.box[1][robot]
    size, margin = clip_box(into, (normals[:count].copy(), offsets[:count].copy()), lower, upper)
    sets.size[robot], sets.margin[0] = size or sets.size[robot], max(sets.margin[0], margin)
