"""All that was ever known of a team in one linear program: where the robots were at every step is a variable each.

Its projection onto the last positions is the least that any filter could claim from the same records: the filter forgets,
this does not. It grows with time, so it is to measure by, not to run.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from filter import Step
from filter.arrays import Array, Integers
from filter.geometry.polygon import Polygon, clip
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.fallback import project_all
from filter.projection.proved import NOTHING, Projection, position
from filter.projection.stop import Stop
from filter.sensing.motion import Displacements, displacements
from filter.sensing.readings import Readings
from filter.sensing.rows import TANGENT_SPACING
from filter.sets.belief import Belief
from filter.sets.passes import Merger
from filter.team import Team

# A displacement set is round where robots slip; so many half-planes stand for it, beside those of its straight edges.
TANGENTS = 32
BEYOND = 1e-3  # [m]
SOLVERS = ("piqp", "highs")


@dataclass(eq=False)
class History:
    """Rows on all positions that robots have had: body n k + i is robot i of n at step k.

    The rows are the filter's own: made by the same functions, with the headings and directions that it knew at each step.
    So a filter that forgot nothing and rounded nothing off would find the same regions.

    Attributes:
        team: The robots and landmarks.
        tangent_spacing: As in the filter [rad].
        tangents: Half-planes evenly around each displacement set; what they leave outside of it is area of the optimum.
    """

    team: Team
    tangent_spacing: float = TANGENT_SPACING
    tangents: int = TANGENTS
    _rows: list[Constraints] = field(default_factory=list)
    _boxes: list[tuple[Array, Array]] = field(default_factory=list)
    _last: Belief | None = None

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, step: Step[Belief]) -> None:
        """Take in the filter's next step."""
        box = wider(step.belief.polytope, self.team.arena)
        now = len(self) * self.team.robots
        measured = self._measured(step)
        if self._last is None:  # what is known before: rows, and a box whose sides need not be rows
            box = step.predicted.polytope.lower, step.predicted.polytope.upper
            rows = [at_step(Constraints.concatenate([step.predicted.constraints, measured]), now)]
        else:
            moves = displacements(step.frame.odometry, self._last.headings, self.team, step.belief.time - self._last.time)
            essential = without_implied(measured, *box)
            rows = [*motion_rows(moves, now, self.tangents), at_step(essential, now)]
        self._rows.append(Constraints.concatenate(rows))
        self._boxes.append(box)
        self._last = step.belief

    def polytope(self, step: int) -> Polytope:
        """Return where all robots can have been at steps 0, 1, ..., `step`."""
        lower, upper = (np.concatenate(corners) for corners in zip(*self._boxes[: step + 1], strict=True))
        return Polytope(Constraints.concatenate(self._rows[: step + 1]), lower, upper)

    def size(self, step: int) -> tuple[int, int]:
        """Return the numbers of variables and of rows of that polytope."""
        return 2 * self.team.robots * (step + 1), sum(map(len, self._rows[: step + 1]))

    def _measured(self, step: Step[Belief]) -> Constraints:
        """Return the rows of a step's bearings and ranges as the filter makes them, before it prunes."""
        before, team = step.predicted, self.team
        readings = Readings.of(before.time, step.frame.measurements)
        sources, numbers = readings.numbered(before.sources, team.robots)
        parts = before.polytope, before.headings, readings, sources, numbers, team.landmarks, self.tangent_spacing
        rows = Merger(*parts).merged().polytope.constraints
        return rows.select(rows.source >= len(before.sources))


def optimum(history: History, step: int, stop: Stop) -> tuple[Projection, ...]:
    """Return each robot's region at a step from the whole history up to it; none if the records exclude one another."""
    robots, polytope = history.team.robots, history.polytope(step)
    bodies = len(polytope.lower)
    planes = [position(bodies - robots + robot, bodies) for robot in range(robots)]
    return project_all(polytope.program(), planes, [NOTHING] * robots, SOLVERS, stop).complete


def motion_rows(moves: Displacements, now: int, tangents: int) -> list[Constraints]:
    """Return the rows on each robot's displacement to its body at `now` from the one before."""
    robots = len(moves.reach)
    around = np.linspace(-np.pi, np.pi, tangents, endpoint=False)
    even = np.stack([np.cos(around), np.sin(around)], axis=1)
    rows = []
    for robot in range(robots):
        normals = np.concatenate([Polygon.hull(moves.vertices[robot]).normals, even])
        offsets = moves.support(np.full(len(normals), robot), normals)
        beyond = np.full(2, 2 * (moves.reach[robot] + moves.slip[robot]) + BEYOND)  # so that no row coincides with a side
        kept = clip(normals, offsets, -beyond, beyond)
        edges = kept[1][kept[1] < len(normals)] if kept else np.arange(len(normals))
        body = np.full(len(edges), now + robot)
        rows.append(Constraints(body - robots, body, normals[edges], offsets[edges], nobody(edges)))
    return rows


def without_implied(rows: Constraints, lower: Array, upper: Array) -> Constraints:
    """Return the rows without those that the others on the same robot or pair imply, within a box (n, 2) and (n, 2)."""
    i, j, first = rows.grouped()
    clipped = Polytope(rows, lower, upper).of(i, j)
    keep = np.repeat(clipped.empty, np.diff(first))  # rows that exclude one another all stay
    keep[clipped.behind[clipped.behind < len(rows)]] = True
    return rows.select(keep)


def at_step(rows: Constraints, first: int) -> Constraints:
    """Return rows on robots as rows on the bodies of a step, of which `first` is robot 0."""
    return Constraints(np.where(rows.i == WORLD, WORLD, rows.i + first), rows.j + first, rows.normal, rows.offset, rows.source)


def wider(polytope: Polytope, arena: Array) -> tuple[Array, Array]:
    """Return lower and upper corners (n, 2) of the polytope's box, three times as wide but within the arena [m].

    A proof needs a box. In one that is no wider than the filter's, a filter that is too small would not be noticed.
    """
    size = polytope.upper - polytope.lower
    return np.maximum(polytope.lower - size, arena[0]), np.minimum(polytope.upper + size, arena[1])


def nobody(rows: Integers) -> Integers:
    """Return a source for each of some rows; nobody asks for it."""
    return np.zeros(len(rows), dtype=np.int64)
