"""One robot among three landmarks: a region that is guaranteed to contain it, and what proves it.

Wheels tell how far the robot has driven, a compass where it heads, ranges how far away the landmarks are. Every error is
unknown but bounded; nothing else is assumed.
"""

import sys

import numpy as np

from filter import Array, Compass, Frame, Odometry, Polygon, Range, SetMembershipFilter, Team, follow

LANDMARKS = np.array([[4.0, 0.0], [0.0, 5.0], [-3.0, -2.0]])
STEP = np.array([0.3, 0.1])  # of the robot, in half a second [m]
COMPASS, RANGE = np.radians(3), 0.1  # the largest errors [rad] and [m]


def world(rng: np.random.Generator) -> tuple[list[Frame], list[Array]]:
    """Return what the robot is given every half second, and where it really is."""
    heading, length = np.arctan2(STEP[1], STEP[0]), np.hypot(*STEP)
    places = rng.uniform(-1, 1, 2) + STEP * np.arange(12)[:, None]
    frames = []
    for k, place in enumerate(places):
        time, said = 0.5 * k, length + rng.uniform(-0.01, 0.01)
        driven = Odometry(time - 0.5, time, 0, said, 0.01, turn=0, turn_bound=0.02, direction_bound=0.01, slip_bound=0.001)
        compass = Compass(time, 0, heading + rng.uniform(-COMPASS, COMPASS), COMPASS)
        true = np.hypot(*(LANDMARKS - place).T)
        ranges = Range(time, [0, 0, 0], [1, 2, 3], true + rng.uniform(-RANGE, RANGE, 3), RANGE, relative_bound=0)
        frames.append(Frame(time, driven if k else None, (compass, ranges)))
    return frames, list(places)


def main(seed: int = 0) -> int:
    """Follow the robot; return 0 if it was inside its region all the time."""
    frames, places = world(np.random.default_rng(seed))
    filter_ = SetMembershipFilter(Team(robots=1, landmarks=LANDMARKS))
    belief = filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])])  # it begins somewhere in this square
    inside = True
    for step, place in zip(follow(filter_, belief, frames), places, strict=True):
        belief, region = step.belief, step.belief.regions[0].outer
        inside &= bool(region.contains(place))
        print(f"{belief.time:.1f} s: the robot is in these {region.area:.3f} m2 around {region.centroid.round(2)}")
    print("The first edge of the last region is proved by", *belief.causes(robot=0, edge=0), sep="\n  ")
    print("The robot was inside all the time." if inside else "The robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
