"""Solvers that lie, to be put into the place of one: each lie takes the true answer and makes something else of it."""

from dataclasses import dataclass, field

import numpy as np

from filter.linear.program import Candidate
from filter.linear.solvers import workspace


def _raised(error):
    def lie(rng, true, last):
        raise error

    return lie


def _farkas(rng, true, last):
    """Say "infeasible": a point as far outside as can be, and weights that shall prove it."""
    return Candidate(np.full_like(true.point, -1e3), rng.exponential(1e3, true.multipliers.shape))


LIES = {
    "the duals' sign is wrong": lambda rng, true, last: Candidate(true.point, -true.multipliers),
    "both signs are wrong": lambda rng, true, last: Candidate(-true.point, -true.multipliers),
    "noisy duals": lambda rng, true, last: Candidate(true.point, true.multipliers * rng.exponential(1, true.multipliers.shape)),
    "dense noise": lambda rng, true, last: Candidate(true.point, rng.exponential(3, true.multipliers.shape)),
    "a noisy point": lambda rng, true, last: Candidate(true.point + rng.normal(size=true.point.shape), true.multipliers),
    "duals that are no number": lambda rng, true, last: Candidate(true.point, np.full_like(true.multipliers, np.nan)),
    "a point that is no number": lambda rng, true, last: Candidate(np.full_like(true.point, np.nan), true.multipliers),
    "infinite duals": lambda rng, true, last: Candidate(true.point, np.full_like(true.multipliers, np.inf)),
    "enormous duals": lambda rng, true, last: Candidate(true.point, np.full_like(true.multipliers, 1e308)),
    "the duals' scale is wrong": lambda rng, true, last: Candidate(true.point, true.multipliers * 10.0 ** rng.uniform(-9, 9)),
    "shifted duals": lambda rng, true, last: Candidate(true.point, np.roll(true.multipliers, 1)),
    "a stale solution": lambda rng, true, last: last or true,
    "optimal without a look": lambda rng, true, last: Candidate(np.zeros_like(true.point), np.zeros_like(true.multipliers)),
    "infeasible": _farkas,
    "gives up": lambda rng, true, last: None,
    "another shape": lambda rng, true, last: Candidate(true.point[1:], true.multipliers[1:]),
    "no arrays": lambda rng, true, last: Candidate("somewhere", "somehow"),
    "no candidate": lambda rng, true, last: "optimal",
    "a time-out": _raised(TimeoutError("too late")),
    "an exception": _raised(RuntimeError("out of luck")),
    "division by zero": _raised(ZeroDivisionError()),
}


@dataclass(eq=False)
class Liar:
    """Makes workspaces that tell one lie, with some probability each time, and the truth otherwise."""

    lie: str
    rng: np.random.Generator
    often: float = 1.0
    told: int = 0
    true: str = "piqp"

    def __call__(self, program):
        return _Lying(self, workspace(program, self.true))


@dataclass(eq=False)
class _Lying:
    liar: Liar
    work: object
    last: Candidate | None = field(default=None)

    def maximize(self, objective):
        true = self.work.maximize(objective)
        if true is None or self.liar.rng.random() >= self.liar.often:
            return true
        self.liar.told += 1
        last, self.last = self.last, self.last or true
        return LIES[self.liar.lie](self.liar.rng, true, last)
