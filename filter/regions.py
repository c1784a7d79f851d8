"""Each robot's region: the projection of the team's polytope, cut with what is known of that robot alone.

The outer polygon's edges become rows themselves: that is how the team's knowledge survives pruning.
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers
from filter.belief import Region, Sources
from filter.constraints import WORLD, Constraints
from filter.errors import Inconsistent
from filter.polygon import Polygon
from filter.polytope import Polytope
from filter.projection import Projection, Stop, position
from filter.projector import project_all

# A row is a cause when its multiplier is above this share of the greatest one: what a solver leaves at less is its rounding.
CAUSE = 1e-6


def regions_at_a_glance(polytope: Polytope) -> tuple[Region, ...]:
    """Return each robot's region from its own rows alone, without a search: larger, sound, nothing known from inside."""
    source = polytope.constraints.source
    regions = []
    for robot in range(len(polytope.lower)):
        outer, edges = polytope.of_robot(robot) or (Polygon.box(*polytope.box_of_robot(robot)), np.arange(-4, 0))
        causes = tuple(source[edge : edge + 1] if edge >= 0 else polytope.source_of_box(robot) for edge in edges)
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
    robots = len(polytope.lower)
    known = [polytope.constraints.select(polytope.constraints.rows_of(WORLD, robot)) for robot in range(robots)]
    planes = [position(robot, robots) for robot in range(robots)]
    projections = project_all(polytope.program(), planes, [(rows.normal, rows.offset) for rows in known], solver, stop)
    if projections.contradiction is not None:
        conflict = sorted(_causes(polytope, projections.contradiction), key=lambda number: (sources.time[number], number))
        raise Inconsistent(f"at {time} s", [sources[number] for number in conflict])
    sources, numbers = sources.extended("region", time, np.arange(robots))
    regions, own = [], []
    for robot, found in enumerate(projections.found):
        region, rows = _region(polytope, robot, known[robot], found, int(numbers[robot]))
        regions.append(region)
        own.append(rows)
    pairs = polytope.constraints.select(polytope.constraints.i != WORLD)
    lower, upper = _boxes(polytope, regions)
    return Polytope(Constraints.concatenate([pairs, *own]), lower, upper, numbers), tuple(regions), sources


def _region(polytope: Polytope, robot: int, known: Constraints, found: Projection, number: int) -> tuple[Region, Constraints]:
    """Return a projection as a region with its causes, and its edges as rows."""
    causes = []
    for edge in found.edges.tolist():
        if edge >= found.searches:
            causes.append(known.source[edge - found.searches :][:1])
        else:
            causes.append(_causes(polytope, found.multipliers[edge]) if edge >= 0 else polytope.source_of_box(robot))
    region = Region(found.outer, found.inner, found.searches, found.reason, tuple(causes))
    fixed = found.edges >= 0
    source = np.append(np.full(found.searches, number), known.source)[found.edges[fixed]]
    return region, Constraints.on_robot(robot, found.outer.normals[fixed], found.outer.offsets[fixed], source)


def _causes(polytope: Polytope, multipliers: Array) -> Integers:
    """Return the numbers of the sources of the rows that multipliers (r,) rest on."""
    return np.unique(polytope.constraints.source[multipliers > CAUSE * multipliers.max(initial=0)])


def _boxes(polytope: Polytope, regions: list[Region]) -> tuple[Array, Array]:
    """Return the boxes around the regions, within the polytope's."""
    corners = np.array([region.outer.bounds for region in regions])
    return np.maximum(polytope.lower, corners[:, 0]), np.minimum(polytope.upper, corners[:, 1])
