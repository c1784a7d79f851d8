"""Is the compiled walk right, and how much of a step is it? Against PIQP's proofs, and within a running filter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time

import numpy as np

from experiments.following.side_by_side import Case
from experiments.following.steps import steps
from experiments.sweep.timing import clocked
from experiments.timed.ways import EXACT, Problem, by_kernel
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.projection.proved import certified_offsets
from filter.projection.team import Projector
from filter.projection.window import Window

PROJECTIONS = ("robots", "pairs")  # by what the filter's step has them made
WARM = 5  # steps that find caches cold


@dataclass(frozen=True)
class Agreement:
    """How the walk's proved edges agree with PIQP's supports in the same directions.

    Attributes:
        windows: How many windows.
        fallbacks: In how many the walk was lost.
        edges: How many edges were compared.
        vertices: How many edges all the exact polygons have.
        apart: The greatest difference of an edge and what PIQP's point reaches [m].
        above: How far an edge is above the bound that PIQP's multipliers prove, at most [m].
        below: How far one is below that bound at most: so loose are PIQP's proofs [m].
        total: The sum of the differences from what PIQP's points reach [m].
    """

    windows: int = 0
    fallbacks: int = 0
    edges: int = 0
    vertices: int = 0
    apart: float = 0.0
    above: float = 0.0
    below: float = 0.0
    total: float = 0.0

    def joined(self, other: Agreement) -> Agreement:
        """Return both together."""
        return Agreement(
            self.windows + other.windows,
            self.fallbacks + other.fallbacks,
            self.edges + other.edges,
            self.vertices + other.vertices,
            max(self.apart, other.apart),
            max(self.above, other.above),
            max(self.below, other.below),
            self.total + other.total,
        )


def agreement_of(problem: Problem, directions: int) -> Agreement:
    """Hold so many edges of the exact projection, evenly chosen, against PIQP's supports in the same directions.

    An edge is proved, so it is above the exact support, by 1e-10 m or so. A point of PIQP's is below it, by its tolerance, and
    what its multipliers prove is above. A direction that PIQP gives up counts as a difference without end.
    """
    found = by_kernel(problem, problem.task(EXACT))
    if not found.first[1]:
        return Agreement(windows=1, fallbacks=1)
    proved = np.flatnonzero(np.diff(found.row_first[: found.first[1] + 1]) > 0)  # no side of the box
    edges = len(proved)
    chosen = proved[np.unique(np.linspace(0, edges, directions, endpoint=False).astype(int))]
    normals, offsets = found.normals[chosen], found.offsets[chosen]
    solver = problem.solver("piqp")
    solved = [solver.maximize(normal @ problem.plane) for normal in normals]
    nothing = np.zeros(len(problem.program.b))
    multipliers = np.array([nothing if each is None else each.multipliers for each in solved])
    above = offsets - certified_offsets(problem.program, problem.plane, normals, multipliers)
    points = np.array([np.full(2, np.inf) if each is None else problem.plane @ each.point for each in solved])
    apart = np.abs(offsets - (points * normals).sum(axis=1))
    sizes = float(apart.max()), float(above.max()), float(-above.min()), float(apart.sum())
    return Agreement(1, 0, len(chosen), edges, *sizes)


@dataclass(frozen=True)
class Shares:
    """Where a running filter's time goes.

    Attributes:
        step: Median of a step, of the process's time [s].
        other: Share of the steps' time that is not projection, certificates included in projection.
    """

    step: float
    other: float


def shares_of(seed: int, duration: float, scope: str) -> Shares:
    """Follow six simulated robots with the default filter, in the team or in windows, and clock its projections."""
    scenario = Case("uniform", seed, 6, duration).scenario()
    team_filter = SetMembershipFilter(scenario.team, scope=Window() if scope == "window" else Window.everybody())
    every, projecting = [], []
    with clocked(Projector, PROJECTIONS) as spent:
        frames = list(scenario.frames)  # so that the simulator's time is not in the steps'
        begin = process_time()
        for _ in steps(team_filter, replace(scenario, frames=iter(frames))):
            every.append(process_time() - begin)
            projecting.append(sum(spent))
            spent.clear()
            begin = process_time()
    warm = slice(min(WARM, len(every) - 1), None)
    return Shares(float(np.median(every[warm])), 1 - sum(projecting[warm]) / sum(every[warm]))
