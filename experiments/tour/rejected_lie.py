"""A rejected lie: a sensor breaks its bound once, and the filter drops what it said, with a proof.

A robot stands among three landmarks and sees how far away they are, and in which direction; of its motion it is only known
to be no faster than 2 m/s. One direction is wrong by a quarter of a turn. Not all of that moment can be true then, and
without that bearing all the rest can. But that it was this one that was wrong is a guess, no proof: so the filter says that its
guarantee is suspended from then on.
"""

import sys

import numpy as np

from filter import Array, Bearing, Compass, Frame, Polygon, Range, SetMembershipFilter, Team, follow

LANDMARKS = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, 0.0]])
ANGLE, LENGTH = np.radians(3), 0.1  # the largest errors, as is promised [rad] and [m]
LIE = 2  # when the bearing of the first landmark is wrong [s]


def world(rng: np.random.Generator, place: Array, heading: float) -> list[Frame]:
    """Return what the robot is given every second."""
    who, whom = [0, 0, 0], [1, 2, 3]
    (x, y), frames = (LANDMARKS - place).T, []
    for time in range(6):
        compass = Compass(time, 0, heading + rng.uniform(-ANGLE, ANGLE), ANGLE)
        seen = np.arctan2(y, x) - heading + rng.uniform(-ANGLE, ANGLE, 3)
        seen[0] += np.pi / 2 if time == LIE else 0.0
        bearings = Bearing(time, who, whom, seen, ANGLE)
        ranges = Range(time, who, whom, np.hypot(x, y) + rng.uniform(-LENGTH, LENGTH, 3), LENGTH, relative_bound=0)
        frames.append(Frame(time, measurements=(compass, bearings, ranges)))
    return frames


def main(seed: int = 0) -> int:
    """Follow the robot; return 0 if it was inside all the time, only the lie was dropped, and the guarantee ended with it."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(-1, 1, 2)
    filter_ = SetMembershipFilter(Team(robots=1, landmarks=LANDMARKS, speed_limit=2.0), policy="reject")
    belief = filter_.start(0.0, [Polygon.box([-3, -3], [3, 3])])
    inside, dropped = True, 0
    for step in follow(filter_, belief, world(rng, place, heading=0.5)):
        region = step.belief.regions[0].outer
        inside &= bool(region.contains(place))
        dropped += len(step.belief.events)
        print(f"{step.belief.time:.0f} s: {region.area:.3f} m2", *step.belief.events, sep="\n     ")
        belief = step.belief
    print(f"The guarantee is {belief.guarantee}.")
    print("The robot was inside all the time." if inside else "The robot was outside!")
    return int(not inside or dropped != 1 or belief.guarantee.suspended_since[0] != LIE)


if __name__ == "__main__":
    sys.exit(main())
