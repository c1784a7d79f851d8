"""Polytopes and programs of teams, and what another solver, or a slow and obvious way, says of them."""

from fractions import Fraction
from itertools import combinations

import numpy as np
from helpers.worlds import World, exact_claim, unit
from scipy import sparse
from scipy.optimize import linprog

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope, prune
from filter.linear.program import LinearProgram
from filter.linear.solvers import deepest_point, workspace
from filter.linear.sources import Sources
from filter.poses.cells import Most
from filter.projection.proved import position
from filter.projection.search import project
from filter.projection.stop import Stop
from filter.projection.team import Projector
from filter.projection.window import Window, links, program_of
from filter.sensing.readings import Readings
from filter.sets.passes import Merger
from filter.sets.proof import Proof

EVERYTHING = Stop(1.0, searches=400)
STRICT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
MANY = 500  # more edges than a walk goes along


def random_polytope(rng, robots, rows, thin=1.0, at=0.0):
    """A team with random rows on robots and pairs around a random configuration; `thin` scales their slack."""
    inside = rng.uniform(-2, 2, (robots, 2)) + at
    j = rng.integers(0, robots, rows)
    i = np.where(rng.random(rows) < 0.4, WORLD, rng.integers(0, robots, rows))
    i = np.where(i == j, WORLD, i)
    normal = unit(rng.uniform(-np.pi, np.pi, rows))
    from_where = np.where((i == WORLD)[:, None], 0.0, inside[i])
    offset = (normal * (inside[j] - from_where)).sum(axis=1) + thin * rng.uniform(0.0, 0.3, rows)
    constraints = Constraints.between(i, j, normal, offset, np.zeros(rows, dtype=int))
    return Polytope(constraints, inside - rng.uniform(0.1, 1, (robots, 2)), inside + rng.uniform(0.1, 1, (robots, 2)))


def merged_team(seed, robots=5, errors="uniform", steps=2):
    """Return the polytope of a team after some steps, as it is before its regions are projected."""
    world = World(np.random.default_rng(seed), robots=robots, errors=errors)
    estimator = SetMembershipFilter(world.team, cells=0)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(steps):
        predicted = estimator.predict(belief, motion.time, motion)
        belief = estimator.update(predicted, records)
    known = merging(predicted, records, world.team, estimator.tangent_spacing, cells=0).merged().polytope
    return known.with_constraints(prune(known, estimator.rows_per_robot, estimator.rows_per_pair))


def merging(belief, records, team, spacing, cells=64):
    """Return what is to be merged of records into a belief."""
    readings = Readings.of(belief.time, records)
    sources, numbers = readings.numbered(belief.sources, team.robots)
    return Merger(belief.polytope, belief.headings, readings, sources, numbers, team.landmarks, spacing, Most(cells, 0))


def with_records(estimator, belief, records):
    """Return the polytope of a belief with the rows of records, as a filter makes them."""
    return merging(belief, records, estimator.team, estimator.tangent_spacing, estimator.cells).merged().polytope


def on_robot(robot, normal, offset, source):
    """Return rows on one robot."""
    return Constraints(np.full(len(offset), WORLD), np.full(len(offset), robot), normal, offset, source)


def single(normals, b, lower, upper):
    """Return the polytope of one robot with rows (r, 2)."""
    normal = np.asarray(normals, dtype=float).reshape(-1, 2)
    rows = on_robot(0, normal, np.asarray(b, dtype=float), np.zeros(len(normal), dtype=int))
    return Polytope(rows, np.array([lower], dtype=float), np.array([upper], dtype=float))


def round_set(middle=(0.0, 0.0), count=MANY):
    """Return a polygon with so many edges that a walk gives up."""
    return Polygon.from_vertices(np.asarray(middle) + unit(2 * np.pi * np.arange(count) / count))


def with_strangers(polytope, places):
    """Return the polytope with more robots at some places of the list, whom nobody knows and whose walks are lost."""
    robots = len(polytope.lower) + len(places)
    others = np.delete(np.arange(robots), places)
    rows, lower, upper = polytope.constraints, np.full((robots, 2), -2.0), np.full((robots, 2), 2.0)
    lower[others], upper[others] = polytope.lower, polytope.upper
    i = np.where(rows.i == WORLD, WORLD, others[rows.i])
    parts, polygon = [Constraints(i, others[rows.j], rows.normal, rows.offset, rows.source)], round_set()
    for robot in places:
        parts.append(on_robot(robot, polygon.normals, polygon.offsets, np.zeros(len(polygon.offsets), dtype=int)))
    return Polytope(Constraints.concatenate(parts), lower, upper)


def box_program(lower, upper, rows=(), b=()):
    A = sparse.csr_array(np.array(rows, dtype=float).reshape(len(rows), len(lower)))
    return LinearProgram(A, np.array(b, dtype=float), np.array(lower, dtype=float), np.array(upper, dtype=float))


def every_pair(robots):
    return np.triu_indices(robots, 1)


def everybody(stop=EVERYTHING, **options):
    """Return what projects the whole team."""
    return Projector(Window.everybody(), stop, **options)


def team_program(polytope, members=None):
    """Return the program that a walk of these members goes on, everybody in order if none are named."""
    robots = len(polytope.lower)
    members = np.arange(robots) if members is None else np.asarray(members)
    place = np.full(robots, -1)
    place[members] = np.arange(len(members))
    rows = polytope.constraints
    inside = (place[rows.j] >= 0) & ((rows.i == WORLD) | (place[rows.i] >= 0))
    return program_of(members, place, np.flatnonzero(inside), rows.rows, (polytope.lower, polytope.upper))


def links_of(polytope):
    return links(polytope.constraints, len(polytope.lower))


def support(program, objective):
    """Return HiGHS's optimum of an objective (v,), with the program moved to its centre."""
    box = np.stack([program.lower - program.centre, program.upper - program.centre], axis=1)
    found = linprog(-objective, program.A.toarray(), program.slack, bounds=box, method="highs", options=STRICT)
    return -found.fun + objective @ program.centre


def supports(polytope, directions, j, i=WORLD):
    """Return (k,) how far the whole team's program lets robot j, or x_j - x_i, go in directions (k, 2), as HiGHS has it."""
    program, robots = polytope.program(), len(polytope.lower)
    D = position(j, robots) - (0 if i == WORLD else position(i, robots))
    return np.array([support(program, direction @ D) for direction in directions])


def searched(program, D, solver="piqp", stop=EVERYTHING):
    """Return the paper's search for one projection."""
    deepest = deepest_point(program, solver)
    return project(program, workspace(program, solver), D, deepest.point, stop=stop)


def exact_bound(program, objective, rows, weights):
    """Return the bound of an objective (v,) that the multipliers of some rows prove, without any rounding."""
    rest, total, A = [Fraction(float(c)) for c in objective], Fraction(0), program.A.toarray()
    for row, weight in zip(rows.tolist(), map(Fraction, weights.tolist()), strict=True):
        total += weight * Fraction(float(program.b[row]))
        rest = [c - weight * Fraction(a) for c, a in zip(rest, A[row].tolist(), strict=True)]
    box = zip(rest, map(Fraction, program.lower.tolist()), map(Fraction, program.upper.tolist()), strict=True)
    return total + sum(max(c * low, c * high) for c, low, high in box)


def excess(polytope, outlines, i, j):
    """Yield by how much the offset that each edge's rows prove, without any rounding, exceeds the edge's own."""
    proof = Proof.of_edges(polytope, Sources(), outlines, (i, j))
    for claim in range(len(proof)):
        yield exact_claim(proof, claim)


def is_possible(polytope, robot, point):
    """Return whether a robot can be at a point (2,), without any rounding, in a team whose other pairs have no rows.

    Then every other robot needs a place of its own: some crossing of two of its lines that is in all its half-planes.
    """
    rows = polytope.constraints
    here = [Fraction(float(x)) for x in point]
    lines = {k: box_lines(polytope, k) for k in range(len(polytope.lower))}
    for i, j, normal, offset in zip(rows.i.tolist(), rows.j.tolist(), rows.normal.tolist(), rows.offset.tolist(), strict=True):
        a, b, c = map(Fraction, (*normal, offset))
        if i == WORLD:
            lines[j].append((a, b, c))
        elif i == robot:
            lines[j].append((a, b, c + a * here[0] + b * here[1]))
        elif j == robot:
            lines[i].append((-a, -b, c - a * here[0] - b * here[1]))
        else:
            raise ValueError("rows on a pair of others")
    own = all(a * here[0] + b * here[1] <= c for a, b, c in lines.pop(robot))
    return own and all(map(has_a_point, lines.values()))


def box_lines(polytope, robot):
    left, bottom, right, top = map(Fraction, (*polytope.lower[robot].tolist(), *polytope.upper[robot].tolist()))
    zero, one = Fraction(0), Fraction(1)
    return [(one, zero, right), (zero, one, top), (-one, zero, -left), (zero, -one, -bottom)]


def has_a_point(lines):
    """Return whether half-planes a x + b y <= c, that leave nothing unbounded, have a point in common."""
    for (a, b, c), (d, e, f) in combinations(lines, 2):
        turn = a * e - b * d
        if turn:
            x, y = (c * e - b * f) / turn, (a * f - c * d) / turn
            if all(p * x + q * y <= r for p, q, r in lines):
                return True
    return False
