"""From wheels to odometry: what the encoders count, and what that says about the motion."""

from __future__ import annotations

import numpy as np

from filter import Array, Odometry
from filter.records.measurements import interval_of_measured
from sim.errors import ErrorKind, Errors
from sim.sensors import Sensors

# How the encoder bound is shared: the rest is for errors that are new at every reading.
RADIUS_SHARE = 0.7
# A step's arc is the difference of two counts, each rounded by half a tick at most.
TICKS_PER_ARC = 1.0
# Room for the rounding of floats in a count; far below any tick.
ROUNDING = 1e-12


class Encoders:
    """The wheel encoders of a team: they count ticks, and no wheel is exactly as large as its nominal radius says."""

    def __init__(
        self, sensors: Sensors, kind: ErrorKind, angles: Array, generator: np.random.Generator, *, wheel_radius: float
    ) -> None:
        """Draw the errors of the radii and set the counters to zero.

        Args:
            sensors: The bounds they keep.
            kind: The kind of errors.
            angles: (n, 2) how far left and right wheels have turned already [rad].
            generator: Where all errors are drawn from.
            wheel_radius: Nominal radius of every wheel [m].

        Raises:
            InvalidInput: There is no such kind of errors.
        """
        self._tick = 2 * np.pi / sensors.ticks
        self._wheel_radius, self._bound = wheel_radius, sensors.encoder_bound
        # Drawn from one channel for each wheel: a biased wheel errs to one side in radius and reading.
        self._errors = Errors(kind, angles.shape, generator)
        self._radius = RADIUS_SHARE * self._errors.draw()
        self._angles, self._turned = angles, np.zeros(angles.shape)
        self._counts = np.zeros(angles.shape)

    def read(self, angles: Array) -> Array:
        """Return (n, 2) arcs that left and right wheel rolled since the last reading, as counted [m].

        Args:
            angles: (n, 2) how far the wheels have turned by now [rad].
        """
        error = self._bound * (self._radius + (1 - RADIUS_SHARE) * self._errors.draw())
        self._turned = self._turned + (angles - self._angles) * (1 + error)
        counts = np.round(self._turned / self._tick)
        arcs = (counts - self._counts) * self._tick * self._wheel_radius
        self._angles, self._counts = angles, counts
        return np.asarray(arcs)


def odometry(sensors: Sensors, arcs: Array, *, wheel_radius: float, track: float, start: float, time: float) -> Odometry:
    """Return what the counted arcs prove about the motion of all robots between two instants.

    Args:
        sensors: The bounds on encoders and slip; how they scale with the time step is said there.
        arcs: (n, 2) arcs of left and right wheel, as counted [m].
        wheel_radius: Nominal radius of every wheel [m].
        track: Distance between left and right wheel [m].
        start: Beginning of the motion [s].
        time: End of the motion [s].

    Raises:
        InvalidInput: The step is so long that the motion may have gone anywhere (direction bound from pi/2 on).
    """
    steps = (time - start) / sensors.slip_step
    swing = sensors.turn_rate * max(0.0, time - start - sensors.slip_step) / 2
    low, high = _arc_intervals(sensors, arcs, wheel_radius)
    distance, distance_bound = _centred(*_path_interval(low.mean(axis=1), high.mean(axis=1), sensors.distance_slip, swing))
    turn, turn_bound = _centred((low[:, 1] - high[:, 0]) / track, (high[:, 1] - low[:, 0]) / track)
    return Odometry(
        start=start,
        time=time,
        robot=np.arange(len(arcs)),
        distance=distance,
        distance_bound=distance_bound,
        turn=turn,
        turn_bound=turn_bound + sensors.turn_slip * steps,
        direction_bound=np.full(len(arcs), sensors.direction_slip + swing),
        slip_bound=np.full(len(arcs), sensors.slip_bound * steps),
    )


def _arc_intervals(sensors: Sensors, arcs: Array, wheel_radius: float) -> tuple[Array, Array]:
    """Return (n, 2) least and greatest arcs that the wheels truly rolled [m]."""
    tick = 2 * np.pi / sensors.ticks * wheel_radius
    bound = np.full(arcs.shape, TICKS_PER_ARC * tick + ROUNDING)
    return interval_of_measured(arcs, bound, np.full(arcs.shape, sensors.encoder_bound))


def _path_interval(low: Array, high: Array, slip: float, swing: float) -> tuple[Array, Array]:
    """Return the least and greatest length of the motion from first to last place, given the wheels' mean arc.

    Slip changes it by its relative bound; a path that swings by up to `swing` around its mean heading is a chord of at
    least cos(swing) of its length.
    """
    shortest, longest = np.cos(swing) * (1 - slip), 1 + slip
    return np.where(low >= 0, low * shortest, low * longest), np.where(high >= 0, high * longest, high * shortest)


def _centred(low: Array, high: Array) -> tuple[Array, Array]:
    return (low + high) / 2, (high - low) / 2
