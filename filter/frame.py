"""What one instant gives: odometry since the last one, measurements, and the truth to judge by."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from filter.arrays import Array, Checked, Floats, checked, floats, instance, settle
from filter.errors import InvalidInput
from filter.measurements import TIME, Measurement, Odometry, measurements_of


@dataclass(frozen=True, eq=False)
class Truth(Checked):
    """Where the robots are.

    Attributes:
        positions: (n, 2) [m]; NaN where nobody knows.
        headings: (n,) yaw in (-pi, pi] [rad].

    Raises:
        InvalidInput: They are no numbers, or not as many.
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


@dataclass(frozen=True, eq=False)
class Frame(Checked):
    """One instant of an episode or a log.

    Attributes:
        time: When [s].
        odometry: The motion since the previous frame, or None in the first one and where nothing is known of it.
        measurements: What was measured at this instant.
        truth: Where the robots are, or None where nobody knows.

    Raises:
        InvalidInput: The time is no number, or something is of another type.
    """

    time: float = field(metadata=TIME)
    odometry: Odometry | None = field(default=None, metadata=checked(instance, "odometry", Odometry, type(None)))
    measurements: tuple[Measurement, ...] = ()
    truth: Truth | None = field(default=None, metadata=checked(instance, "truth", Truth, type(None)))

    if TYPE_CHECKING:  # whatever holds records is taken, a tuple is kept

        def __init__(
            self,
            time: float,
            odometry: Odometry | None = ...,
            measurements: Iterable[Measurement] = ...,
            truth: Truth | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        settle(self, measurements=measurements_of(self.measurements))
