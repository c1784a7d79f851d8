"""Each robot's region: the projection of the team's polytope, cut with what is known of that robot alone.

The outer polygon's edges become rows themselves: that is how the team's knowledge survives pruning.
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers
from filter.belief import Region, Sources
from filter.constraints import WORLD, Constraints
from filter.errors import Inconsistent
from filter.polygon import clip
from filter.polytope import Polytope
from filter.projection import Projection, Stop, position, project
from filter.solvers import deepest_point, workspace

# A row is a cause when its multiplier is above this share of the greatest one: what a solver leaves at less is its rounding.
CAUSE = 1e-6


def regions_at_a_glance(polytope: Polytope) -> tuple[Region, ...]:
    """Return each robot's region from its own rows alone, without a search: larger, sound, nothing known from inside."""
    source = polytope.constraints.source
    regions = []
    for robot in range(len(polytope.lower)):
        outer, edges = polytope.of_robot(robot)
        causes = tuple(source[edge : edge + 1] if edge >= 0 else source[:0] for edge in edges)
        regions.append(Region(outer, None, 0, None, causes))
    return tuple(regions)


def searched(
    time: float, polytope: Polytope, sources: Sources, solver: str, stop: Stop
) -> tuple[Polytope, tuple[Region, ...], Sources]:
    """Search every robot's region in the whole team's polytope.

    Returns:
        The polytope with the regions' edges as the only rows on single robots and with the regions' boxes, the regions,
        and the table of sources with the regions entered.

    Raises:
        Inconsistent: The polytope is proved to be empty.
    """
    program = polytope.program()
    deepest = deepest_point(program, solver)
    if deepest is not None and program.proves_empty(deepest.multipliers):
        conflict = sorted(_causes(polytope, deepest.multipliers), key=lambda number: (sources.time[number], number))
        raise Inconsistent(f"at {time} s", [sources[number] for number in conflict])
    interior = program.centre if deepest is None else deepest.point
    robots = len(polytope.lower)
    sources, numbers = sources.extended("region", time, np.arange(robots))
    directions = workspace(program, solver)
    regions, own = [], []
    for robot in range(robots):
        found = project(program, directions, position(robot, robots), interior, stop)
        region, rows = _region(polytope, robot, found, int(numbers[robot]))
        regions.append(region)
        own.append(rows)
    pairs = polytope.constraints.select(polytope.constraints.i != WORLD)
    lower, upper = _boxes(polytope, regions)
    return Polytope(Constraints.concatenate([pairs, *own]), lower, upper), tuple(regions), sources


def _region(polytope: Polytope, robot: int, found: Projection, number: int) -> tuple[Region, Constraints]:
    """Cut the projection with the robot's own rows; return the region and its edges as rows."""
    rows = polytope.constraints.select((polytope.constraints.i == WORLD) & (polytope.constraints.j == robot))
    fresh = len(found.outer.offsets)
    normals, offsets = np.concatenate([found.outer.normals, rows.normal]), np.concatenate([found.outer.offsets, rows.offset])
    kept = clip(normals, offsets, polytope.lower[robot], polytope.upper[robot])
    # None: proved to be empty, which an update will find, and name the causes, once a solver can tell.
    outer, edges = kept or (found.outer, np.arange(fresh))
    causes = []
    for edge in edges.tolist():
        if edge < 0 or (edge < fresh and found.edges[edge] < 0):
            causes.append(rows.source[:0])
        elif edge < fresh:
            causes.append(_causes(polytope, found.multipliers[found.edges[edge]]))
        else:
            causes.append(rows.source[edge - fresh : edge - fresh + 1])
    source = np.concatenate([np.full(fresh, number), rows.source])
    fixed = edges[edges >= 0]
    region = Region(outer, found.inner, found.searches, found.reason, tuple(causes))
    return region, Constraints.on_robot(robot, normals[fixed], offsets[fixed], source[fixed])


def _causes(polytope: Polytope, multipliers: Array) -> Integers:
    """Return the numbers of the sources of the rows that multipliers (r,) rest on."""
    return np.unique(polytope.constraints.source[multipliers > CAUSE * multipliers.max(initial=0)])


def _boxes(polytope: Polytope, regions: list[Region]) -> tuple[Array, Array]:
    """Return the boxes around the regions, within the polytope's."""
    corners = np.array([region.outer.bounds for region in regions])
    return np.maximum(polytope.lower, corners[:, 0]), np.minimum(polytope.upper, corners[:, 1])
