"""How the Kalman filter is tuned to each kind of errors: the one place.

A deviation is the standard deviation of the simulator's true errors over the bound that is declared for them.

Compass, bearings and ranges err anew each time (or, for `bias`, always the same), so theirs follow from the distributions
in `sim.errors`. Wheels do not: a wheel that is too large is so at every step, errors add up, and a filter that takes them
for independent believes itself too much. So theirs are measured over three seconds, `odometry_deviations`: independent
errors of this size add up, in three seconds, to what the true ones do. Three, because then the filter is consistent: with
deviations of single steps its NEES is 3.8 instead of 2, with those of one second 2.2, of three 1.95, of five 1.8 (gaussian
errors, 16 runs of 60 s that the comparison does not use). The size of its ellipses hardly changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from filter import Array, Frame, NoiseModel, wrap
from sim.errors import ErrorKind

HORIZON = 30  # steps of three seconds
STANDING = 0.005  # a step of less is taken for standing [m]

GAUSSIAN = 0.9866 / 3  # three deviations are the bound, and what exceeds it is drawn again
EXTREME = 1.0
BIAS = 0.9  # the root mean square of a constant between 0.85 and 0.95 and the little that varies
# Slip comes from the wheels' physics, the same for every kind, and is far below its bound.
DIRECTION, SLIP = 0.069, 0.032

# A model of which nothing is said is that of errors uniform over their bounds.
TUNED: Mapping[ErrorKind, NoiseModel] = {
    "uniform": NoiseModel(distance=0.96, turn=1.12, direction=DIRECTION, slip=SLIP),
    "bias": NoiseModel(BIAS, BIAS, BIAS, distance=2.28, turn=2.66, direction=DIRECTION, slip=SLIP),
    "extreme": NoiseModel(EXTREME, EXTREME, EXTREME, distance=1.82, turn=2.07, direction=DIRECTION, slip=SLIP),
    "gaussian": NoiseModel(GAUSSIAN, GAUSSIAN, GAUSSIAN, distance=0.60, turn=0.62, direction=DIRECTION, slip=SLIP),
}
# What is done when nothing is known but bounds: take each for three standard deviations.
CONSERVATIVE = NoiseModel.same(1 / 3)


def odometry_deviations(frames: Sequence[Frame], horizon: int = HORIZON) -> dict[str, float]:
    """Return the deviations over bounds of distance, turn, direction and slip that a run with known truth shows.

    Args:
        frames: A run in which every robot has odometry at each step.
        horizon: Over how many steps errors are added up; 1 for the errors of single steps.

    Algorithm:
        With errors e and bounds b of single steps, the root of mean (sum e)^2 over mean sum b^2, sums over the horizon.
        Direction is judged where robots drive, slip where they stand.
    """
    odometry = [frame.odometry for frame in frames if frame.odometry is not None]
    column = {name: np.array([getattr(record, name) for record in odometry]) for name in vars(odometry[0])}
    positions = np.array([frame.truth.positions for frame in frames if frame.truth is not None])
    headings = np.array([frame.truth.headings for frame in frames if frame.truth is not None])
    moved, turned = np.diff(positions, axis=0), wrap(np.diff(headings, axis=0))
    way = headings[:-1] + turned / 2
    along = moved[..., 0] * np.cos(way) + moved[..., 1] * np.sin(way)
    across = moved[..., 1] * np.cos(way) - moved[..., 0] * np.sin(way)
    drives = np.abs(column["distance"]) > STANDING
    swerve = np.abs(column["distance"]) * column["direction_bound"]
    return {
        "distance": _deviation(along - column["distance"], column["distance_bound"], horizon),
        "turn": _deviation(turned - column["turn"], column["turn_bound"], horizon),
        "direction": _deviation(across * drives, swerve * drives, horizon),
        "slip": _deviation(across * ~drives, column["slip_bound"] * ~drives, horizon),
    }


def _deviation(errors: Array, bounds: Array, horizon: int) -> float:
    """Return the deviation over bound of (t, n) errors that are added up over the horizon; 0 where no bound is."""
    whole = len(errors) // horizon * horizon
    sums = errors[:whole].reshape(-1, horizon, errors.shape[1]).sum(axis=1)
    total = (bounds[:whole] ** 2).sum()
    return float(np.sqrt((sums**2).sum() / total)) if total else 0.0
