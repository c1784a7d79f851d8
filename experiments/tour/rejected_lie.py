"""A rejected lie: a sensor breaks its bound once; the filter goes on with all that can be the case, until the doubt is over.

A robot stands among three landmarks and sees how far away they are, and in which direction; of its motion it is only known
to be no faster than 0.1 m/s and 0.1 rad/s. One direction is wrong by a quarter of a turn. Not all of that can be true then. It
can have been the sensor, or the landmark, or that landmark alone as this robot sees it: if it was one of these, the robot is
within the region, which is larger for a while. But all that the sensor says goes on agreeing with the compass, so that it is
listened to again; and in the end all agrees, whatever it was.
"""

import sys

import numpy as np

from filter import Array, Bearing, Compass, Frame, Polygon, Range, SetMembershipFilter, Team, follow

LANDMARKS = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, 0.0]])
ANGLE, LENGTH = np.radians(3), 0.1  # the largest errors, as is promised [rad] and [m]
LIE, SELDOM, END = 2, 10, 60  # when a bearing is wrong; how seldom something is said, if nothing happens; when all ends [s]


def world(rng: np.random.Generator, place: Array, heading: float) -> list[Frame]:
    """Return what the robot is given every second."""
    who, whom = [0, 0, 0], [1, 2, 3]
    (x, y), frames = (LANDMARKS - place).T, []
    for time in range(END):
        compass = Compass(time, 0, heading + rng.uniform(-ANGLE, ANGLE), ANGLE)
        seen = np.arctan2(y, x) - heading + rng.uniform(-ANGLE, ANGLE, 3)
        seen[0] += np.pi / 2 if time == LIE else 0.0
        bearings = Bearing(time, who, whom, seen, ANGLE)
        ranges = Range(time, who, whom, np.hypot(x, y) + rng.uniform(-LENGTH, LENGTH, 3), LENGTH, relative_bound=0)
        frames.append(Frame(time, measurements=(compass, bearings, ranges)))
    return frames


def main(seed: int = 0) -> int:
    """Follow the robot; return 0 if it was inside all the time, the guarantee in force, and the doubt is over at the end."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(-1, 1, 2)
    filter_ = SetMembershipFilter(Team(robots=1, landmarks=LANDMARKS, speed_limit=0.1, turn_rate_limit=0.1), policy="reject")
    belief = filter_.start(0.0, [Polygon.box([-3, -3], [3, 3])])
    good = True
    for step in follow(filter_, belief, world(rng, place, heading=0.5)):
        belief = step.belief
        region = belief.regions[0].outer
        good &= bool(region.contains(place) and belief.guarantee.in_force[0])
        if belief.events or belief.time % SELDOM == 0:
            print(f"{belief.time:.0f} s: {region.area:.3f} m2", *belief.events, sep="\n     ")
    print(f"The guarantee is {belief.guarantee}.")
    print("The robot was inside all the time." if good else "The robot was outside!")
    return int(not good or bool(belief.suspects) or bool(belief.aside))


if __name__ == "__main__":
    sys.exit(main())
