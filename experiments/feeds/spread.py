"""How values are spread, in little memory, however many there are."""

from __future__ import annotations

from math import exp, floor, log

import numpy as np

LEAST, MOST = 1e-9, 1e9  # values beyond are counted there
FINE = log(1.01)  # a bin is 1 % wide
BINS = floor(log(MOST / LEAST) / FINE) + 2


class Spread:
    """Counts values from 0 on in bins that are 1 % wide.

    Attributes:
        count: How many there are.
        total: Their sum.
        most: The greatest one.
    """

    def __init__(self) -> None:
        self.count, self.total, self.most = 0, 0.0, 0.0
        self._bins = np.zeros(BINS, dtype=np.int64)

    def add(self, value: float) -> None:
        """Count one."""
        self.count, self.total, self.most = self.count + 1, self.total + value, max(self.most, value)
        self._bins[floor(log(min(max(value, LEAST), MOST) / LEAST) / FINE)] += 1

    def mean(self) -> float | None:
        """Return the mean, or None of nothing."""
        return self.total / self.count if self.count else None

    def quantile(self, share: float) -> float | None:
        """Return what such a share of the values is not above: at most 1 % more than it had to be; None of nothing."""
        if not self.count:
            return None
        bin_ = int(np.searchsorted(np.cumsum(self._bins), share * self.count))
        return min(self.most, LEAST * exp((bin_ + 1) * FINE))
