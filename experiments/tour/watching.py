"""Watching a Kalman filter: a guaranteed region proves an estimate wrong, without knowing the truth.

A robot drives straight on. Its compass errs by nearly its bound and always to the same side, as compasses do. A Kalman filter
takes errors for independent, and grows sure of a wrong place; the region that follows from the same records shows it.
"""

import sys

import numpy as np

from filter import Compass, ExtendedKalmanFilter, Frame, Odometry, Polygon, Range, SetMembershipFilter, Team, follow, watch

TEAM = Team(robots=1, landmarks=[[0.0, 8.0]])
STEP = np.array([0.25, 0.0])  # of the robot, in half a second [m]
ANGLE, LENGTH = np.radians(5), 0.05  # the largest errors [rad] and [m]


def frame(rng: np.random.Generator, k: int) -> Frame:
    """Return what the robot is given at its k-th step."""
    time, said = 0.5 * k, 0.25 + rng.uniform(-0.005, 0.005)
    driven = Odometry(time - 0.5, time, 0, said, 0.005, turn=0, turn_bound=0.01, direction_bound=0.01, slip_bound=0.001)
    compass = Compass(time, 0, ANGLE * rng.uniform(0.85, 0.95), ANGLE)  # its true heading is 0
    distance = np.hypot(*(TEAM.landmarks[0] - k * STEP)) + rng.uniform(-LENGTH, LENGTH)
    return Frame(time, driven if k else None, (compass, Range(time, 0, 1, distance, LENGTH, relative_bound=0)))


def main(seed: int = 0) -> int:
    """Follow the robot with both filters; return 0 if it was inside its region all the time."""
    rng = np.random.default_rng(seed)
    frames, start = [frame(rng, k) for k in range(40)], [Polygon.box([-0.2, -0.2], [0.2, 0.2])]
    sets, kalman = SetMembershipFilter(TEAM), ExtendedKalmanFilter(TEAM)
    known = [step.belief for step in follow(sets, sets.start(0.0, start), frames)]
    guesses = [step.belief.mean[:, :2] for step in follow(kalman, kalman.start(0.0, start), frames)]
    inside = all(belief.regions[0].outer.contains(k * STEP) for k, belief in enumerate(known))
    alarms = [alarm for belief, guess in zip(known, guesses, strict=True) for alarm in watch(belief, guess)]
    print(f"{len(alarms)} of {len(frames)} estimates are proved wrong. The first, and the one that is farthest off:")
    print(*alarms[:1], *sorted(alarms, key=lambda alarm: alarm.distance)[-1:], sep="\n")
    print("The robot was inside its region all the time." if inside else "The robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
