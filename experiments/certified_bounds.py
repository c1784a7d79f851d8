"""Are certified bounds above the truth, how far, and what do they cost? Against exact rational arithmetic.

Run `python -m experiments.certified_bounds --help`. The exit code is 0 only if no bound was below the truth.

Random programs, near and far from the origin, small and large. The truth of each is enclosed: it is no less than what a point
reaches that is feasible in exact arithmetic, and no more than what the solver's multipliers prove in exact arithmetic.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from time import perf_counter
from typing import TypeVar

import numpy as np
from rich.progress import track
from scipy import sparse

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, rounded
from experiments.following.simulated import from_simulator
from experiments.following.steps import steps
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Terminal, print_table
from filter import Array, Belief, Mask, SetMembershipFilter
from filter.geometry.polygon import SIDES
from filter.linear.program import LinearProgram
from filter.linear.solvers import deepest_point, workspace
from filter.projection.proved import position
from sim.episode import episode

ORIGINS = (0.0, 1.0, 5e6)  # [m]
ROBOTS, ROWS, DIRECTIONS = 2, 12, 20
REPEATS = 3  # of each timing; the least counts, as nobody else's work is in it
T = TypeVar("T")


@dataclass(frozen=True)
class Options:
    """Hold certified bounds against exact rational arithmetic, and measure what they cost on a moving team.

    Exit code 0 only if no bound was below the truth.
    """

    bounds: int = 100_000
    """How many bounds."""
    duration: float = 5.0
    """How long the team moves whose linear programs are timed [s]."""
    seed: int = 0
    """Where all randomness comes from."""
    out: Path = Path("runs/certified_bounds")
    """Folder for the summary."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("certified_bounds", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option cannot be used.
    """
    keep_within(options, bounds=(1, np.inf), duration=(0.1, np.inf))
    folder = output_folder(options.out)
    rng = np.random.default_rng(options.seed)
    programs = -(-options.bounds // DIRECTIONS)
    tried = [tried_bounds(drawn(rng, ORIGINS[k % len(ORIGINS)]), rng) for k in _tracked(range(programs), "bounds", programs)]
    below, excess, known = (np.concatenate(column) for column in zip(*tried, strict=True))
    loose = excess[known]
    costs = [np.min([cost(belief) for _ in range(REPEATS)], axis=0) for belief in beliefs(options.duration, options.seed)]
    solving, certifying, verifying = np.sum(costs, axis=0)
    summary: dict[str, Value] = {
        "seed": options.seed,
        "bounds": len(below),
        "bounds_below_truth": int(below.sum()),
        "bounds_with_a_feasible_point": len(loose),
        "looseness_median_m": rounded(float(np.median(loose))),
        "looseness_p99_m": rounded(float(np.quantile(loose, 0.99))),
        "looseness_max_m": rounded(float(loose.max())),
        "solving_s": rounded(float(solving)),
        "certifying_s": rounded(float(certifying)),
        "verifying_inner_points_s": rounded(float(verifying)),
        "certifying_over_solving": rounded(float(certifying / solving)),
    }
    write_summary(folder, summary)
    print_table(f"certified_bounds, in {folder}", summary)
    return int(below.any())


def drawn(rng: np.random.Generator, origin: float) -> LinearProgram:
    """Return a random program of rows on single robots and on pairs, around a point of its own."""
    size = 10.0 ** rng.uniform(-2, 2)
    angles, first = rng.uniform(-np.pi, np.pi, ROWS), rng.random(ROWS) < 0.5
    normals, alone = np.stack([np.cos(angles), np.sin(angles)], axis=1), rng.random(ROWS) < 0.5
    A = np.zeros((ROWS, 2 * ROBOTS))
    A[:, :2] = np.where((first | ~alone)[:, None], normals, 0)
    A[:, 2:] = np.where(alone[:, None], np.where(first[:, None], 0, normals), -normals)
    middle = origin + rng.uniform(-1, 1, 2 * ROBOTS)
    return LinearProgram(sparse.csr_array(A), A @ middle + size * rng.uniform(0.1, 1, ROWS), middle - size, middle + 2 * size)


def tried_bounds(program: LinearProgram, rng: np.random.Generator) -> tuple[Mask, Array, Mask]:
    """Return of each of some random directions whether the bound is below the truth, how far above it at most, if known [m]."""
    angles = rng.uniform(-np.pi, np.pi, DIRECTIONS)
    c = np.zeros((DIRECTIONS, 2 * ROBOTS))
    c[:, :2] = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    solver, deepest = workspace(program, "piqp"), deepest_point(program, "piqp")
    found = [solver.maximize(direction) for direction in c]
    nothing = np.zeros(ROWS)
    y = program.essential(c, np.array([one.multipliers if one else nothing for one in found]))
    points = np.array([one.point if one else program.centre for one in found])
    points = program.pulled(points, program.centre if deepest is None else deepest.point)
    bounds, holds = program.certified_bounds(c, y), program.holds(points)
    proved = [exact_bound(program, direction, weights) for direction, weights in zip(c, y, strict=True)]
    reached = [_dot(direction, point) for direction, point in zip(c, points, strict=True)]
    exact = [Fraction(bound) for bound in bounds.tolist()]
    below = [bound < most or (h and bound < least) for bound, most, least, h in zip(exact, proved, reached, holds, strict=True)]
    excess = [float(bound - least) for bound, least in zip(exact, reached, strict=True)]
    return np.array(below), np.array(excess), holds


def exact_bound(program: LinearProgram, objective: Array, multipliers: Array) -> Fraction:
    """Return what multipliers from 0 on prove of an objective over the program's polytope, without any rounding."""
    used = np.flatnonzero(multipliers)
    A, y = program.A[used].toarray(), multipliers[used]
    total = _dot(y, program.b[used])
    for k, value in enumerate(objective):
        rest = Fraction(float(value)) - _dot(y, A[:, k])
        total += rest * Fraction(float(program.upper[k] if rest > 0 else program.lower[k]))
    return total


def _dot(a: Array, b: Array) -> Fraction:
    products = (Fraction(x) * Fraction(y) for x, y in zip(a.tolist(), b.tolist(), strict=True) if x and y)
    return sum(products, Fraction(0))


def beliefs(duration: float, seed: int) -> Iterator[Belief]:
    """Yield the beliefs of a filter that follows a simulated team."""
    simulated = episode(robots=6, duration=duration, rate=10.0, seed=seed, errors="uniform", measurements="all")
    scenario = from_simulator(simulated, 10.0)
    for step in _tracked(steps(SetMembershipFilter(scenario.team), scenario), "cost", scenario.count):
        yield step.belief


def cost(belief: Belief) -> tuple[float, float, float]:
    """Return how long a step's solving takes, the proofs of edges, boxes and emptiness, and those of inner points [s]."""
    (*_, edges), (*_, boxes) = belief.proofs_of("regions"), belief.proofs_of("boxes")
    program, again, robots = edges.polytope.program(), edges.polytope.program(), len(belief.regions)
    objectives = [edges.normal[edges.j == robot] @ position(robot, robots) for robot in range(robots)]
    begin = perf_counter()
    solver, deepest = workspace(program, "piqp"), deepest_point(program, "piqp")
    found = [[one for one in map(solver.maximize, each) if one] for each in objectives]
    solved = perf_counter()
    if deepest is None or [len(each) for each in found] != [len(each) for each in objectives]:
        return 0.0, 0.0, 0.0  # a solver gave up: not counted at all
    again.proves_empty(deepest.multipliers)
    for directions, each in zip(objectives, found, strict=True):
        again.certified_bounds(directions, again.essential(directions, np.array([one.multipliers for one in each])))
    weights = np.zeros((len(boxes), len(boxes.polytope.constraints)))
    weights[np.repeat(np.arange(len(boxes)), boxes.weights.counts), boxes.weights.row] = boxes.weights.weight
    boxes.polytope.program().certified_bounds(np.kron(np.eye(robots), SIDES), weights)
    certified = perf_counter()
    again.holds(deepest.point[None])
    for each in found:
        again.holds(again.pulled(np.array([one.point for one in each]), deepest.point))
    return solved - begin, certified - solved, perf_counter() - certified


def _tracked(items: Iterable[T], what: str, count: int | None) -> Iterable[T]:
    return track(items, what, total=count, console=Terminal(stderr=True))


if __name__ == "__main__":
    sys.exit(main())
