"""The Kalman filter that real robots are compared with: how it is tuned, in one place."""

from __future__ import annotations

from filter import ExtendedKalmanFilter, NoiseModel, Team

# Deviations over the declared bounds, from the published quantiles of three runs (docs/real-robots.md), not from any one.
# Ranges: 90 % of the errors below 0.29 m and 99 % below 0.60 m, where the bound is 15 % of some 4 m: 0.18 to 0.23 m.
# Bearings: 90 % below 1.2 to 1.7 degrees, 99 % below 2.4 to 3.8, of 7.5: 0.9 to 1.5 degrees. Both half as much again, as
# the errors of a robot repeat themselves, and the filter takes them for independent.
# Motion: records of a frame each, some twelve a second, are taken for independent. They shall add up to what is seen in a
# second and in ten: 17 degrees and 30 degrees at most, 0.06 m/s, taken for 3.3 deviations.
NOISE = NoiseModel(range=0.5, bearing=0.3, distance=0.4, turn=0.2, direction=0.33, slip=0.25)
GATE = 0.999  # of each number's normalised innovation squared: barcodes are confused


def kalman_filter(team: Team) -> ExtendedKalmanFilter:
    """Return the Kalman filter of a team."""
    return ExtendedKalmanFilter(team, NOISE, GATE)
