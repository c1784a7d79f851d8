"""The options of a tolerance, which several commands have."""

from __future__ import annotations

from dataclasses import dataclass

from filter import InvalidInput, Lies, SuspectClass, Tolerance


@dataclass(frozen=True)
class Tolerating:
    """How many may lie, and who."""

    tolerate: int = 0
    """Hold the truth although so many of the suspects lie within any window; but for identities each case takes a belief of its
    own, and time."""
    suspects: tuple[SuspectClass, ...] = ("pairs",)
    """Who may lie: pairs (what a robot takes for a target), bodies (place or marker), cameras (a robot's sensor), compasses;
    or identities (of each robot, what it and one other body measure of one another)."""
    lies: Lies = "any"
    """any; long: ranges may be too long, and nothing else is wrong, as with radio."""
    window: float = 5.0
    """Within how long a time no more lie [s]."""

    def tolerance(self) -> Tolerance | None:
        """Return what the filter tolerates; None for nothing.

        Raises:
            InvalidInput: A number means nothing, or options would change nothing.
        """
        if self.tolerate:
            return Tolerance(self.tolerate, self.window, self.suspects, self.lies)
        if self != Tolerating():
            raise InvalidInput("a --tolerate above 0 for --suspects, --lies and --window", "--tolerate 0")
        return None
