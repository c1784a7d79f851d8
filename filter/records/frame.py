"""What one instant gives a filter, and the truth, where somebody knows it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from filter.arrays import Array, Floats, Frozen, checked, floats, instance, several
from filter.errors import InvalidInput
from filter.records.measurements import Measurement, measurements_of
from filter.records.odometry import Odometry
from filter.records.presence import Change, Left, Placed
from filter.records.record import TIME


@dataclass(frozen=True, eq=False)
class Truth(Frozen):
    """Where the robots are. Raises `InvalidInput` if these are no numbers, or not as many.

    Attributes:
        positions: (n, 2) [m]; NaN where nobody knows.
        headings: (n,) yaw in (-pi, pi] [rad].
    """

    positions: Array = field(metadata=checked(floats, "positions [m]"))
    headings: Array = field(metadata=checked(floats, "headings [rad]"))

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(self, positions: Floats, headings: Floats) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        positions, headings = self.positions.shape, self.headings.shape
        if len(headings) != 1 or positions != (*headings, 2):
            raise InvalidInput("positions (n, 2) and headings (n,)", f"shapes {positions} and {headings}")


def _changes(records: Iterable[Change]) -> tuple[Change, ...]:
    return several("records of robots that are placed or have left", records, Placed, Left)


@dataclass(frozen=True, eq=False)
class Frame(Frozen):
    """One instant of an episode or a log. Raises `InvalidInput` if something is of another type.

    Attributes:
        time: When [s].
        odometry: The motion since the previous frame, or None in the first one and where nothing is known of it.
        measurements: What was measured at this instant; kept as a tuple.
        truth: Where the robots are, or None where nobody knows.
        changes: Who was put somewhere and who left, in this order, after the motion and before the measurements; a tuple.
    """

    time: float = field(metadata=TIME)
    odometry: Odometry | None = field(default=None, metadata=checked(instance, "odometry", Odometry, type(None)))
    measurements: Sequence[Measurement] = field(default=(), metadata={"check": measurements_of})
    truth: Truth | None = field(default=None, metadata=checked(instance, "truth", Truth, type(None)))
    changes: Sequence[Change] = field(default=(), metadata={"check": _changes})
