"""One window, projected onto a robot or onto a pair: compiled from the rows of the team to certified edges.

Of a pair i, j it is the position of j as seen from i, x_j - x_i, as in `Constraints`; of a robot j alone i is WORLD.
"""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled, put, sum_of
from filter.geometry.convex import EPSILON, SMALLEST, clip_box, line_behind
from filter.geometry.many import Groups
from filter.linear.certify import WORTHLESS, Boxes, Members, certified
from filter.linear.constraints import WORLD
from filter.projection.inside import inside_of
from filter.projection.shadow import LONGEST, LONGEST_EACH, Trace, no_trace, simplified, turn
from filter.projection.sheet import Sheet, Task
from filter.projection.simplex import EMPTY, FOUND, LOST, Basis, become_feasible, combination, corner, spread
from filter.projection.window import WindowProgram, members_of, program_of, rows_in

# How far the first objective leads away from the plane that is projected onto.
ASIDE = 0.01
# An edge that is certified this much beyond where it was found, relative to the box, shows that the walk went wrong.
BEYOND = 1e-7


class Plane(NamedTuple):
    """What is projected onto: the first member's position, or that as seen from the second, in units of their boxes.

    Attributes:
        right: (v,) objective in the program's units whose value is the first coordinate.
        up: (v,) that of the second coordinate.
        size: (2,) what the coordinates are measured in [m].
        middle: (2,) where they are 0 [m].
        far: How large the positions' coordinates are, summed up [m].
    """

    right: Array
    up: Array
    size: Array
    middle: Array
    far: float


class Edges(NamedTuple):
    """Edges of a shadow that were kept.

    Attributes:
        normals: (s, 2).
        offsets: (s,) certified [m].
        rows: (s, v) the rows that prove each, the number of all rows for none.
        prices: (s, v) their multipliers.
        why: What decided which were kept, a place in `REASONS`.
    """

    normals: Array
    offsets: Array
    rows: Integers
    prices: Array
    why: int


@compiled
def project_some(pairs: tuple[Integers, Integers], own: Groups, around: Boxes, task: Task, sheet: Sheet) -> int:
    """Project the windows of k pairs i, j, or of robots j where i is WORLD, onto a sheet.

    Each has a group of rows of its own, and a box around it.

    Returns:
        0; or, where a window is proved to be empty, how many rows prove that: these are the first ones of the sheet.
    """
    place = np.full(len(task.box[0]), -1)
    for k in range(len(pairs[0])):
        rows, box = (own[0][k], own[1][k]), (around[0][k], around[1][k])
        proof = project_window(k, pairs[0][k], pairs[1][k], rows, box, task, place, sheet)
        if proof:
            return proof
    return 0


@compiled
def project_window(
    k: int, i: int, j: int, own: tuple[int, int], around: Boxes, task: Task, place: Integers, sheet: Sheet
) -> int:
    """Project one window onto the k-th place of a sheet, of which all before is written; `place` (n,) is scratch, all -1."""
    members = members_of(i, j, task.hops, task.most, task.who, place)
    numbers = rows_in(members, place, task.who)
    program = program_of(members, place, numbers, task.team, task.box)
    plane = plane_of(program, i != WORLD)
    how, trace, basis, contradicted = walked(program, plane)
    seen, where, proof = vertices_of(trace, plane), (place, program.centre, program.radius), 0
    sheet.first[k + 1], sheet.corner_first[k + 1] = sheet.first[k], sheet.corner_first[k]
    sheet.margin[k], sheet.searches[k], sheet.why[k] = 0.0, 0, 0
    if how == EMPTY and i == WORLD:
        row, weight = contradiction(program, basis, contradicted)
        if certified(i, j, np.zeros(2), weight, row, where, task.team) < 0:
            proof = len(row)
            for m in range(proof):
                sheet.row[m], sheet.weight[m] = row[m], weight[m]
    if how == FOUND:
        how, edges = edges_of(i, j, program, plane, trace, seen, where, task)
        if how == FOUND:
            write_outline(k, edges, own, around, task, sheet)
            if task.inside:
                corners = inside_of(program, (trace, basis, plane.right), seen, numbers, (members, place, task.box), task.team)
                sheet.corner_first[k + 1] += len(corners)
                for m in range(len(corners)):
                    put(corners[m], sheet.corners[sheet.corner_first[k] + m])
    for member in members:
        place[member] = -1
    return proof


@compiled
def plane_of(program: WindowProgram, mutual: bool) -> Plane:
    """Return the plane of the first member, or of the pair of the first two."""
    variables, size, middle = len(program.centre), np.empty(2), np.empty(2)
    axes, far = np.zeros((2, variables)), 0.0
    for m in range(2):
        far += abs(program.centre[m]) + (abs(program.centre[2 + m]) if mutual else 0.0)
        second = program.radius[2 + m] if mutual else 0.0
        size[m], middle[m] = program.radius[m] + second, program.centre[m]
        if size[m] > 0:
            axes[m, m] = program.radius[m] / size[m]
        if mutual:
            middle[m] -= program.centre[2 + m]
            axes[m, 2 + m] = -second / size[m] if size[m] > 0 else 0.0
    return Plane(axes[0], axes[1], size, middle, far)


@compiled
def walked(program: WindowProgram, plane: Plane) -> tuple[int, Trace, Basis, int]:
    """Walk to a vertex, and then around the shadow; return how that ended, what was seen, and a row that cannot be satisfied.

    The first objective leads to the plane's right, and a little aside in every variable, so that nothing is parallel.
    """
    variables = len(program.centre)
    start, prices = np.empty(variables), np.empty(variables)
    for k in range(variables):
        ahead = plane.right[k] if plane.right[k] != 0 else ASIDE * (1.0 - 2.0 * (k % 2))
        start[k] = (0.5 + 0.5 * spread(k + 1)) * ahead
        prices[k] = abs(start[k])
    basis, nothing, trace = corner(program.rows, start), no_trace(0, variables), no_trace(LONGEST, variables)
    limit = LONGEST + LONGEST_EACH * variables
    how, contradicted = become_feasible(program.rows, basis, prices, limit)
    if how == FOUND and not (
        turn(program.rows, basis, start, plane.right, np.pi / 2, nothing, limit) == FOUND
        and turn(program.rows, basis, plane.right, plane.up, 2 * np.pi, trace, limit) == FOUND
        and trace.filled[0] < LONGEST
    ):
        how = LOST
    return how, trace, basis, contradicted


@compiled
def vertices_of(trace: Trace, plane: Plane) -> Array:
    """Return the vertices (t, 2) of a shadow in the plane's units."""
    seen = np.zeros((trace.filled[0], 2))
    for k in range(len(seen)):
        for v in range(len(plane.right)):
            seen[k, 0] += plane.right[v] * trace.point[k, v]
            seen[k, 1] += plane.up[v] * trace.point[k, v]
    return seen


@compiled
def contradiction(program: WindowProgram, basis: Basis, contradicted: int) -> tuple[Integers, Array]:
    """Return constraints and weights that say: the contradicted row and the basic ones exclude one another."""
    count, found = len(program.number), 0
    shares = np.empty(len(basis.basic))
    combination(program.rows, basis, contradicted, shares)
    row, weight = np.empty(len(shares) + 1, dtype=np.int64), np.empty(len(shares) + 1)
    for k in range(len(shares) + 1):
        number = basis.basic[k] if k < len(shares) else contradicted
        share = -shares[k] if k < len(shares) else 1.0
        if number < count and share > 0:
            row[found], weight[found] = program.number[number], share / program.size[number]
            found += 1
    return row[:found].copy(), weight[:found].copy()


@compiled
def edges_of(
    i: int, j: int, program: WindowProgram, plane: Plane, trace: Trace, seen: Array, where: Members, task: Task
) -> tuple[int, Edges]:
    """Return whether the walk went well, FOUND or LOST, and the edges of its shadow that matter, proved."""
    count, variables = trace.filled[0], len(program.centre)
    kept, why = simplified(trace.normal[:count], seen, plane.size[0] * plane.size[1], task.goal)
    normals, offsets = np.empty((len(kept), 2)), np.empty(len(kept))
    rows, prices = np.full((len(kept), variables), len(task.team[3])), np.zeros((len(kept), variables))
    how = FOUND
    for at in range(len(kept)):
        k = kept[at]
        x = trace.normal[k, 0] / (plane.size[0] if plane.size[0] > 0 else 1.0)
        y = trace.normal[k, 1] / (plane.size[1] if plane.size[1] > 0 else 1.0)
        length = np.hypot(x, y)
        normals[at, 0], normals[at, 1] = x / length, y / length
        for m in range(variables):
            basic = trace.basic[k, m]
            if basic < len(program.number) and trace.prices[k, m] > WORTHLESS:
                rows[at, m], prices[at, m] = program.number[basic], trace.prices[k, m] / (length * program.size[basic])
        offsets[at] = certified(i, j, normals[at], prices[at], rows[at], where, task.team)
        # A region's loose edge is for a solver to better; a pair's is cut by the rows that it had.
        if i == WORLD and not is_tight(plane, seen[k], normals[at], offsets[at], sum_of(prices[at])):
            how = LOST
    return how, Edges(normals, offsets, rows, prices, why)


@compiled
def is_tight(plane: Plane, vertex: Array, normal: Array, offset: float, price: float) -> bool:
    """Return whether a proved edge is no farther out than its vertex (2,), but for rounding: more where rows cost more."""
    reached = 0.0
    for m in range(2):
        reached += normal[m] * (plane.middle[m] + plane.size[m] * vertex[m])
    return offset - reached <= BEYOND * max(plane.size[0], plane.size[1]) + 64 * EPSILON * plane.far * (1 + price) + SMALLEST


@compiled
def write_outline(k: int, edges: Edges, own: tuple[int, int], around: Boxes, task: Task, sheet: Sheet) -> None:
    """Write the polygon that edges and the robot's or the pair's own rows leave of its box, and the rows that prove it."""
    (begin, end), (lower, upper), searches = own, around, len(edges.offsets)
    normals, offsets = np.empty((searches + end - begin, 2)), np.empty(searches + end - begin)
    for line in range(len(offsets)):
        row = begin + line - searches
        for m in range(2):
            normals[line, m] = edges.normals[line, m] if line < searches else task.team[2][row, m]
        offsets[line] = edges.offsets[line] if line < searches else task.team[3][row]
    first, behind = sheet.first[k], np.empty(len(offsets) + 4, dtype=np.int64)
    into = sheet.vertices[first:], behind
    size, sheet.margin[k] = clip_box(into, (normals, offsets), lower, upper)
    count = sheet.row_first[first]
    for edge in range(size):
        line, at = behind[edge], first + edge
        x, y, reach = line_behind(line, (normals, offsets), lower, upper)
        sheet.normals[at, 0], sheet.normals[at, 1], sheet.offsets[at] = x, y, reach
        if line < searches:
            for m in range(edges.rows.shape[1]):
                if edges.rows[line, m] < len(task.team[3]):
                    sheet.row[count], sheet.weight[count] = edges.rows[line, m], edges.prices[line, m]
                    count += 1
        elif line < len(offsets):
            sheet.row[count], sheet.weight[count] = begin + line - searches, 1.0
            count += 1
        sheet.row_first[at + 1] = count
    sheet.first[k + 1], sheet.searches[k], sheet.why[k] = first + size, searches, edges.why
