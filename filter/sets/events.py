"""What happens in an update beside the update: measurements that were dropped, solvers that failed."""

from dataclasses import dataclass

from filter.linear.sources import Source


@dataclass(frozen=True)
class Rejected:
    """A measurement that was dropped, as the filter's policy says, for measurements to agree again.

    Attributes:
        source: What was dropped.
        conflict: What was proved to exclude one another, the dropped one with it or resting on it.
    """

    source: Source
    conflict: tuple[Source, ...]

    def __str__(self) -> str:
        return f"rejected {self.source}; in conflict: {'; '.join(map(str, self.conflict))}"


@dataclass(frozen=True)
class Fallback:
    """A walk was lost, or a solver's answers were no good, and others were asked for.

    Attributes:
        robot: Whose region was searched, or None for the deepest point of the whole team.
        failed: The "walk" and the solvers whose answers were no good, in the order they were asked.
        used: The solver whose answers were good, or None: what is proved anyway, and what was propagated, has to do.
        seen_from: The other robot of a pair, if it was the region of one seen from the other.
    """

    robot: int | None
    failed: tuple[str, ...]
    used: str | None
    seen_from: int | None = None

    def __str__(self) -> str:
        what = "the deepest point" if self.robot is None else f"the region of robot {self.robot}"
        what += "" if self.seen_from is None else f" seen from robot {self.seen_from}"
        return f"{what}: no good answer of {', '.join(self.failed)}, {self.used or 'nobody'} took over"


Event = Rejected | Fallback
