"""Branch and prune of one robot's poses: cells are split until they are small for what was measured."""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import bounds_of, compiled, place_of_least, put, sum_of
from filter.geometry.angles import ANGLE_ROUNDING
from filter.geometry.convex import EPSILON, hull_of, largest_of
from filter.geometry.simplify import edges_worth_keeping
from filter.linear.polytope import APART
from filter.poses.cell import CELL_CORNERS, Said, Scale, cut, cuts_at_most, pruned
from filter.poses.cone import wrapped
from filter.poses.slices import COUNT, DIRECTIONS
from filter.poses.split import where_to_split
from filter.sensing.rows import WIDENING

TOLERANCE = 0.02  # a cell that is no wider than this is not split (see `where_to_split`)
OF_SLICES = 2  # slices, most of which are narrow already, are split into half as many cells
NOT_KNOWN = -1.0  # how wide a piece is that nobody has looked at
HULL_EDGES, FEW_EDGES = 24, 8  # of the hull, and of what is enough for others, at most


class Tree(NamedTuple):
    """How sets of poses were split into c cells at most, to do it again; filled by `branch`, from the roots 0 to r - 1 on.

    Attributes:
        line: (2 c, 3) along which each piece was split (see `where_to_split`).
        child: (2 c,) the first of its two pieces, 0 where it was not.
        rounds: (2 c,) in which each piece was cut.
        root: (c,) from which root each leaf is, what is left in the end; -1 where there are fewer leaves.
        arcs: (c, 2) of leaves, centre and bound [rad].
        reach: (c, COUNT) supports of leaves [m].
    """

    line: Array
    child: Integers
    rounds: Integers
    root: Integers
    arcs: Array
    reach: Array


class Roots(NamedTuple):
    """The sets of poses that are split, one of which holds the robot's.

    Attributes:
        corners: (v, 2) of their polygons, one after the other, or no farther than a margin beyond these [m].
        first: (r + 1,) where those of each begin; one without corners is empty.
        heading: (r, 2) their arcs, centre and bound [rad].
    """

    corners: Array
    first: Integers
    heading: Array


class Pieces(NamedTuple):
    """Cells that are left, and room for more of them.

    Attributes:
        tree: In which they are.
        root: (c,) from which root each is.
        corners: (c, CELL_CORNERS, 2) of each.
        size: (c,) how many it has.
        heading: (c, 2) its arc, centre and bound [rad].
        split: (c, 4) how badly it is too wide, or NOT_KNOWN, and the line to split it along (see `where_to_split`).
        node: (c,) where it is in the tree.
        alive: (1,) how many there are.
    """

    tree: Tree
    root: Integers
    corners: Array
    size: Integers
    heading: Array
    split: Array
    node: Integers
    alive: Integers


@compiled
def branch(roots: Roots, heading: Array, said: Said, margin: float, tree: Tree) -> Array:
    """Return half-planes (k, 4) around all places that a robot can have; none if it is proved to have none.

    They are normal and offset, and whether they are among the few that are enough for others, 1 or 0. The arc (2,) of its
    heading is narrowed in place.
    """
    largest = max(largest_of(roots.corners), largest_of(said.points))
    most = len(tree.child) // 2
    rounding = 8 * EPSILON * largest * most * cuts_at_most(said)  # each cut makes vertices from those that one before has made
    scale = Scale(largest, margin + rounding, np.empty((CELL_CORNERS + 2, 2)))
    left = Pieces(
        tree,
        np.zeros(most, dtype=np.int64),
        np.empty((most, CELL_CORNERS, 2)),
        np.zeros(most, dtype=np.int64),
        np.empty((most, 2)),
        np.empty((most, 4)),
        np.zeros(most, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
    )
    for root in range(len(roots.heading)):
        _plant(left, root, roots, said, scale)
    count = len(roots.heading)
    enough = most if count == 1 else max(count, most // OF_SLICES)
    for nodes in range(count, len(tree.child) - 1, 2):
        if not 0 < left.alive[0] < enough:
            break
        _weigh(left, said, scale)
        k = place_of_least(-left.split[: left.alive[0], 0])
        if left.split[k, 0] <= TOLERANCE:
            break
        for m in range(3):
            tree.line[left.node[k], m] = left.split[k, 1 + m]
        tree.child[left.node[k]] = nodes
        _split(left, k, nodes, said, scale)
    _hull_of_arcs(heading, left.heading[: left.alive[0]])
    _gather(left, scale.margin)
    return _outline(left, scale.margin)


@compiled
def _plant(left: Pieces, root: int, roots: Roots, said: Said, scale: Scale) -> None:
    """Cut one of the sets that are to be split, and keep what is left of it."""
    k, begin, size = left.alive[0], roots.first[root], roots.first[root + 1] - roots.first[root]
    left.root[k], left.node[k] = root, root
    for m in range(size):
        put(roots.corners[begin + m], left.corners[k, m])
    put(roots.heading[root], left.heading[k])
    _prune(left, k, size, said, scale)
    left.alive[0] += int(left.size[k] > 0)


@compiled
def _gather(left: Pieces, margin: float) -> None:
    """Write what is left in each cell into the tree, as outward as the outline around all of them."""
    root, arcs, reach = left.tree.root, left.tree.arcs, left.tree.reach
    for k in range(left.alive[0]):
        root[k] = left.root[k]
        corners = left.corners[k, : left.size[k]]
        (west, east), (south, north) = bounds_of(corners[:, 0]), bounds_of(corners[:, 1])
        outward = 2 * margin + APART * ((east - west) + (north - south))
        arcs[k, 0], arcs[k, 1] = left.heading[k, 0], min(np.pi, left.heading[k, 1] + WIDENING)
        for m in range(COUNT):
            reach[k, m] = -np.inf
            for v in range(len(corners)):
                reach[k, m] = max(reach[k, m], DIRECTIONS[m, 0] * corners[v, 0] + DIRECTIONS[m, 1] * corners[v, 1])
            reach[k, m] += outward


@compiled
def _prune(left: Pieces, k: int, size: int, said: Said, scale: Scale) -> None:
    """Cut a piece by everything; how wide it is then is not known yet."""
    left.size[k], left.split[k, 0] = size, NOT_KNOWN
    if size:
        pose = left.corners[k], left.heading[k]
        left.size[k], left.tree.rounds[left.node[k]] = pruned(pose, size, said, scale)


@compiled
def _weigh(left: Pieces, said: Said, scale: Scale) -> None:
    """Look how wide pieces are of which that is not known."""
    for k in range(left.alive[0]):
        if left.split[k, 0] == NOT_KNOWN:
            pose = left.corners[k], left.heading[k]
            need, x, y, offset = where_to_split(pose, left.size[k], said, scale)
            left.split[k, 0], left.split[k, 1], left.split[k, 2], left.split[k, 3] = need, x, y, offset


@compiled
def _split(left: Pieces, k: int, node: int, said: Said, scale: Scale) -> None:
    """Put two pieces in the place of one, and cut both; those of which nothing is left are gone."""
    (_, x, y, offset), last = left.split[k], left.alive[0]
    _copy(left, k, last)
    left.root[last], left.node[k], left.node[last] = left.root[k], node, node + 1
    left.alive[0] += 1
    for piece, side in ((last, -1.0), (k, 1.0)):  # the one that another may take the place of comes last
        size, arc = left.size[piece], left.heading[piece]
        if x == 0 and y == 0:
            arc[1] = arc[1] / 2 + ANGLE_ROUNDING
            arc[0] = wrapped(arc[0] - side * arc[1])
        else:
            size = cut(left.corners[piece], size, (side * x, side * y, side * offset), scale)
        _prune(left, piece, size, said, scale)
        if not left.size[piece]:
            left.alive[0] -= 1
            _copy(left, left.alive[0], piece)


@compiled
def _copy(left: Pieces, k: int, to: int) -> None:
    for m in range(left.size[k]):
        left.corners[to, m, 0], left.corners[to, m, 1] = left.corners[k, m, 0], left.corners[k, m, 1]
    left.heading[to, 0], left.heading[to, 1] = left.heading[k, 0], left.heading[k, 1]
    for m in range(4):
        left.split[to, m] = left.split[k, m]
    left.size[to], left.node[to], left.root[to] = left.size[k], left.node[k], left.root[k]


@compiled
def _hull_of_arcs(heading: Array, arcs: Array) -> None:
    """Write an arc around all of (k, 2) arcs, if there are any and it is narrower."""
    low, high = np.inf, -np.inf
    for k in range(len(arcs)):
        turn = wrapped(arcs[k, 0] - arcs[0, 0])
        low, high = min(low, turn - arcs[k, 1]), max(high, turn + arcs[k, 1])
    half = (high - low) / 2 + WIDENING
    if len(arcs) and half < heading[1]:
        heading[0], heading[1] = wrapped(arcs[0, 0] + (low + high) / 2), half


@compiled
def _outline(left: Pieces, margin: float) -> Array:
    """Return half-planes (k, 4) around all pieces (see `branch`)."""
    corners, count = np.empty((sum_of(left.size[: left.alive[0]]), 2)), 0
    for k in range(left.alive[0]):
        for m in range(left.size[k]):
            corners[count, 0], corners[count, 1] = left.corners[k, m, 0], left.corners[k, m, 1]
            count += 1
    if not count:
        return np.empty((0, 4))
    hull = hull_of(corners)
    edges = len(hull) if len(hull) > 2 else 4
    lines, level, all_of_them = np.empty((edges, 4)), np.empty(edges), np.ones(edges, dtype=np.bool_)
    x, y = sum_of(hull[:, 0]) / len(hull), sum_of(hull[:, 1]) / len(hull)
    (west, east), (south, north) = bounds_of(hull[:, 0]), bounds_of(hull[:, 1])
    for k in range(edges):
        angle = k * np.pi / 2
        if edges == len(hull):
            following = hull[(k + 1) % edges]
            angle = np.arctan2(hull[k, 0] - following[0], following[1] - hull[k, 1])
        lines[k, 0], lines[k, 1], lines[k, 2] = np.cos(angle), np.sin(angle), -np.inf
        for m in range(len(hull)):
            lines[k, 2] = max(lines[k, 2], lines[k, 0] * hull[m, 0] + lines[k, 1] * hull[m, 1])
        level[k] = lines[k, 2] - lines[k, 0] * x - lines[k, 1] * y
        # Or it would almost coincide with a reading's; and arithmetic that rounds otherwise can prove it again, like the arc of
        # headings, which is wider by `WIDENING`.
        lines[k, 2] += 2 * margin + APART * ((east - west) + (north - south))
    keep, _ = edges_worth_keeping(lines[:, :2].copy(), level, all_of_them, np.int64(HULL_EDGES), 0.0)
    lines, level, all_of_them = lines[keep], level[keep], all_of_them[keep]
    few, _ = edges_worth_keeping(lines[:, :2].copy(), level, all_of_them, np.int64(FEW_EDGES), -1.0)
    put(few, lines[:, 3])
    return lines
