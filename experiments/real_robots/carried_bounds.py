"""Bounds for a filter that carries a heading along, from a run with truth: what of its errors is jitter, what drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.following.frozen import freeze
from experiments.real_robots.bounds import DEGREE, Bounds
from experiments.real_robots.carried import Carried, CarriedBounds
from experiments.real_robots.data import Run
from experiments.real_robots.errors import EVERY, LENGTHS, Errors, driven
from experiments.real_robots.motion import Motions
from filter import Array, wrap

TURNED, DROVE = 0.2, 0.05  # shares are of intervals in which a robot was told to turn [rad] or drive [m] more than this


@dataclass(frozen=True, eq=False)
class Moves:
    """What a team was told, and what it did, in intervals of one length; only where the truth is known and nobody was silent.

    Attributes:
        length: Of the intervals [s].
        told: (k, 4) commanded path and its absolute value [m], turn and its absolute value [rad].
        did: (k, 3) path, slip [m] and turn [rad].
    """

    length: float
    told: Array
    did: Array

    def __post_init__(self) -> None:
        freeze(self)

    @classmethod
    def of(cls, run: Run, robots: Sequence[int], carried: Carried, length: float) -> Moves:
        """Return the moves of some robots, all of them in one table."""
        told, did = [np.zeros((0, 4))], [np.zeros((0, 3))]
        for index, robot in enumerate(robots):
            truth = run.logs[robot].truth
            start = np.arange(0.0, max(truth[-1, 0] - length if len(truth) else 0.0, 0.0), EVERY)
            moved = carried.moved(index, start, start + length)
            path, slip, turn, unbroken = driven(run, robot, start, start + length)
            known = unbroken & (moved[:, 4] == 0)
            told.append(moved[known, :4])
            did.append(np.column_stack([path, slip, turn])[known])
        return cls(length, np.concatenate(told), np.concatenate(did))


def proposed_carried(
    run: Run, robots: Sequence[int], found: Sequence[Errors], clocks: Bounds, *, share: float, margin: float
) -> CarriedBounds:
    """Return bounds that a share of the run's errors at most would have broken, with a margin on those of motion.

    The absolute bound of ranges and the drifts stay as they are. The share of turns is judged by long intervals with the jitter
    as it is, and then the jitter by all with the share found: two parts of one error, which no run tells apart.

    Args:
        run: Its truth must be known.
        robots: By their numbers in the files.
        found: Errors of "range" and "bearing" among others.
        clocks: Its lag and speed scale are taken over.
        share: Of the errors.
        margin: Times what the share says, for jitter, turn, path and slip.
    """
    known = replace(CarriedBounds(), command_lag=clocks.command_lag, speed_scale=clocks.speed_scale)
    carried = Carried(Motions(run, robots, clocks), known)
    moves = [Moves.of(run, robots, carried, length) for length in LENGTHS]
    by_kind, long = {errors.kind: errors for errors in found}, moves[-1]
    scale = _fitted(long.told[:, 2], long.did[:, 2], known.turn_scale)
    known = replace(_seen(known, by_kind, share), turn_scale=scale)
    turned, drove = long.told[:, 3] > TURNED, long.told[:, 1] > DROVE
    turn_share = _within((_left(long, known) - 2 * known.jitter)[turned] / long.told[turned, 3], share)
    known = replace(known, turn_share=_up(margin * turn_share, 0.01))
    jitter = max(_within(_left(each, known) - known.turn_share * each.told[:, 3], share) for each in moves) / 2
    way = known.speed_scale * long.told[:, :2]
    off = np.abs(long.did[:, 0] - way[:, 0]) - known.distance_drift * long.length
    return replace(
        known,
        jitter=_up(margin * jitter / DEGREE, 0.1) * DEGREE,
        distance_share=_up(margin * _within(off[drove] / way[drove, 1], share), 0.01),
        slip=_up(margin * _within(np.abs(long.did[:, 1]), share) / long.length, 0.001),
    )


def _seen(bounds: CarriedBounds, by_kind: dict[str, Errors], share: float) -> CarriedBounds:
    """Return the bounds with those of ranges, to either side, and of bearings."""
    ranges, bearings = by_kind["range"], by_kind["bearing"]
    away = ranges.true > 0
    beyond = [(side * ranges.error[away] - bounds.range) / ranges.true[away] for side in (-1, 1)]
    shortest, longest = (_up(_within(part, share / 2), 0.01) for part in beyond)
    bearing = _up(_within(np.abs(bearings.error), share) / DEGREE, 0.1) * DEGREE
    return replace(bounds, shortest=min(shortest, 0.99), longest=longest, bearing=bearing)


def _left(moves: Moves, bounds: CarriedBounds) -> Array:
    """Return (k,) how much of a turn's error the constant drift does not cover."""
    error = np.abs(wrap(moves.did[:, 2] - bounds.turn_scale * moves.told[:, 2]))
    return np.asarray(error - bounds.turn_drift * moves.length)


def _fitted(told: Array, did: Array, otherwise: float) -> float:
    """Return the scale that fits best."""
    power = float(told @ told)
    return max(round(float(told @ did) / power, 3), 0.0) if power > 0 else otherwise


def _within(values: Array, share: float) -> float:
    """Return what no more than a share of the values is beyond, or 0 if it is less."""
    return max(float(np.quantile(values, 1 - share, method="higher")), 0.0) if len(values) else 0.0


def _up(value: float, step: float) -> float:
    return round(float(np.ceil(value / step - 1e-9)) * step, 6)
