"""What is promised, held against the truth, a step at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.following.located import inside, there
from filter import Belief, GaussianBelief, Guarantee, Mask, Measurement, Position, Truth

Known = Belief | GaussianBelief  # what a filter knows


@dataclass(frozen=True)
class Escapes:
    """Robots whose truth was outside at one step: a broken guarantee.

    Attributes:
        positions: Robots outside their outer polygon.
        headings: Robots whose heading is outside its interval.
    """

    positions: tuple[int, ...] = ()
    headings: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.positions or self.headings)


@dataclass
class Checks:
    """Counts what was checked.

    A check is one robot at one step that is there and whose truth is known.

    Attributes:
        checks: Positions that were checked.
        escapes: Positions outside their outer polygon.
        heading_checks: Headings that were checked.
        heading_escapes: Headings outside their interval.
        escapes_in_force: Those of both for which the guarantee was said to be in force: broken promises.
        suspended: The guarantee as it was when it first was suspended for some robot; None for never.
        measurements: Numbers that were measured: a compass reading, a bearing or a range counts one each, and so does the
            position of a robot or of its antenna, however many half-planes it has.
    """

    checks: int = 0
    escapes: int = 0
    heading_checks: int = 0
    heading_escapes: int = 0
    escapes_in_force: int = 0
    suspended: Guarantee | None = None
    measurements: int = 0

    def measured(self, record: Measurement) -> None:
        """Count what a record has measured."""
        self.measurements += len(set(record.first.tolist())) if isinstance(record, Position) else len(record.robot)

    def promised(self, belief: Known) -> None:
        """Take in what a belief says of its guarantee."""
        if self.suspended is None and belief.guarantee.lapsed.any():
            self.suspended = belief.guarantee

    def check(self, belief: Belief, truth: Truth) -> Escapes:
        """Hold a belief against the truth; return who is outside."""
        here = there(belief)
        placed, turned = np.isfinite(truth.positions).all(axis=1) & here, np.isfinite(truth.headings) & here
        within = belief.headings.contains(np.where(turned, truth.headings, 0.0)) | ~turned
        found = Escapes(_missing(inside(belief, truth.positions) | ~placed), _missing(within))
        self.checks += int(placed.sum())
        self.heading_checks += int(turned.sum())
        self.escapes += len(found.positions)
        self.heading_escapes += len(found.headings)
        self.escapes_in_force += int(belief.guarantee.in_force[[*found.positions, *found.headings]].sum())
        return found

    @property
    def broken(self) -> bool:
        """Whether any position or heading has escaped while the guarantee was said to be in force."""
        return self.escapes_in_force > 0

    def counts(self) -> dict[str, int]:
        """Return how much was checked, and how much of it was outside, by the names in a summary."""
        names = ("checks", "escapes", "heading_checks", "heading_escapes", "escapes_in_force")
        return {name: getattr(self, name) for name in names}


def _missing(holds: Mask) -> tuple[int, ...]:
    return tuple(np.flatnonzero(~holds).tolist())
