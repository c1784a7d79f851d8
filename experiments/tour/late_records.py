"""Late records: what a slow camera saw is merged where it belongs, as if it had come in time.

The wheels of a robot are heard at once; what its camera sees comes late and in any order. Around any filter, `FixedLag` keeps
the last steps and does them again with what has come. What is later than the lag is refused, counted, and told by an event.
"""

import sys

import numpy as np

from filter import Array, Bearing, Compass, FixedLag, Measurement, Odometry, Polygon, Range, SetMembershipFilter, Team

TEAM = Team(robots=1, landmarks=[[3.0, 2.0], [6.0, -2.0]])
SPEED = np.array([0.5, 0.0])  # [m/s]
ANGLE, SHARE = np.radians(3), 0.03  # the largest errors of angles [rad], and of a range its share


def driven(start: float, time: float) -> Odometry:
    """Return what the wheels say of the motion between any two times: straight on."""
    duration = time - start
    return Odometry(start, time, 0, 0.5 * duration, 0.02 * duration, 0, 0.02 * duration, 0.01, 0.002 * duration)


def seen(rng: np.random.Generator, time: float, place: Array) -> list[Measurement]:
    """Return what camera and compass say of one moment; the robot heads along x."""
    x, y = (TEAM.landmarks - place).T
    bearings = Bearing(time, [0, 0], [1, 2], np.arctan2(y, x) + rng.uniform(-ANGLE, ANGLE, 2), ANGLE)
    ranges = Range(time, [0, 0], [1, 2], np.hypot(x, y) * rng.uniform(1 - SHARE, 1 + SHARE, 2), 0, SHARE)
    return [Compass(time, 0, rng.uniform(-ANGLE, ANGLE), ANGLE), bearings, ranges]


def main(seed: int = 0) -> int:
    """Follow the robot; return 0 if it was inside its region all the time."""
    rng = np.random.default_rng(seed)
    begin, moments = rng.uniform(-0.5, 0.5, 2), 0.5 * np.arange(1, 17)
    arrivals = moments + rng.uniform(0, 2, len(moments))
    filter_ = SetMembershipFilter(TEAM)
    lag = FixedLag(filter_, driven, lag=1.0)
    lagged = lag.begin(filter_.start(0.0, [Polygon.box([-0.5, -0.5], [0.5, 0.5])]))
    inside = True
    for moment, arrival in sorted(zip(moments, arrivals, strict=True), key=lambda pair: pair[1]):
        lagged = lag.merge(lagged, seen(rng, moment, begin + moment * SPEED))
        now, region = lagged.belief.time, lagged.belief.regions[0].outer
        inside &= bool(region.contains(begin + now * SPEED))
        print(f"{arrival:5.2f} s: what was seen at {moment} s comes; at {now} s the robot is in {region.area:.3f} m2")
    print(f"{lagged.late} numbers came late and were merged all the same, {lagged.refused} came too late.")
    print("The robot was inside all the time." if inside else "The robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
