"""Errors to put on perfect readings: unknown but bounded, in four kinds.

Everything drawn here is relative: in [-1, 1], to be multiplied by the bound that the sensor declares.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from filter import Array, InvalidInput

ErrorKind = Literal["uniform", "bias", "extreme", "gaussian"]
ERROR_KINDS: tuple[ErrorKind, ...] = get_args(ErrorKind)

BIAS = (0.85, 0.95)  # least and greatest magnitude of a bias; the rest up to 1 varies
DEVIATION = 1 / 3  # standard deviation of a gaussian error, before what exceeds the bound is drawn again


class Errors:
    """Relative errors of one kind of sensor, one channel for each robot (or wheel).

    The kinds: "uniform" in [-1, 1]; "bias", constant in each channel but for a little, so that averaging fails; "extreme",
    -1 or +1, nothing between; "gaussian", normal, a third of the bound wide and drawn again beyond it.
    """

    def __init__(self, kind: ErrorKind, channels: tuple[int, ...], generator: np.random.Generator) -> None:
        """Draw what stays constant.

        Args:
            kind: One of `ERROR_KINDS`.
            channels: Shape of the array of channels.
            generator: Where all errors are drawn from.

        Raises:
            InvalidInput: There is no such kind.
        """
        self._kind, self._generator = known_kind(kind), generator
        self._bias = generator.uniform(*BIAS, channels) * generator.choice([-1.0, 1.0], channels)

    def draw(self, each: int | None = None) -> Array:
        """Return relative errors in [-1, 1]: one for each channel, or, shape (*channels, each), several for each."""
        bias = self._bias if each is None else np.broadcast_to(self._bias[..., None], (*self._bias.shape, each))
        if self._kind == "bias":
            varies = 1 - np.abs(bias)
            return np.asarray(np.clip(bias + varies * self._generator.uniform(-1, 1, bias.shape), -1, 1))
        if self._kind == "extreme":
            return self._generator.choice([-1.0, 1.0], bias.shape)
        if self._kind == "gaussian":
            return self._truncated_normal(bias.shape)
        return self._generator.uniform(-1, 1, bias.shape)

    def _truncated_normal(self, shape: tuple[int, ...]) -> Array:
        errors = self._generator.normal(0, DEVIATION, shape)
        while (beyond := np.abs(errors) > 1).any():
            errors[beyond] = self._generator.normal(0, DEVIATION, int(beyond.sum()))
        return errors


def known_kind(kind: str) -> ErrorKind:
    """Return the kind of errors, if it is one.

    Raises:
        InvalidInput: It is not.
    """
    for known in ERROR_KINDS:
        if kind == known:
            return known
    raise InvalidInput(f"a kind of errors among {', '.join(ERROR_KINDS)}", repr(kind))
