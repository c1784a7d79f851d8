"""No compass: a robot finds out where it is and where it heads, although it mistakes a landmark for another now and then.

The filter keeps a region for each slice of headings that is still possible. Its promise holds although, of what is seen in any
two seconds, one sighting may be wrong; where more are, this is in doubt until it is found out.
"""

import sys

import numpy as np

from filter import Array, Bearing, Frame, Odometry, Polygon, Range, SetMembershipFilter, Team, Tolerance, follow, wrap

LANDMARKS = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, 0.0], [0.0, -4.0]])
ANGLE, SHARE = np.radians(3), 0.05  # the largest errors of a bearing [rad], and of a range its share


def world(rng: np.random.Generator) -> tuple[list[Frame], list[Array]]:
    """Return what the robot is given every half second, as it drives in circles, and where it really is."""
    begin, first, radius = rng.uniform(-1, 1, 2), rng.uniform(-np.pi, np.pi), 1.0
    frames, places = [], []
    for k in range(40):
        time, heading = 0.5 * k, first + 0.2 * k
        place = begin + radius * np.array([np.sin(heading), -np.cos(heading)])
        turn = 0.2 + rng.uniform(-0.02, 0.02)
        driven = Odometry(time - 0.5, time, 0, 0.2 * radius, 0.01, turn, 0.02, direction_bound=0.01, slip_bound=0.001)
        seen = rng.integers(4)
        taken_for = (seen + (rng.random() < 0.1)) % 4  # a mistake in one of ten
        x, y = LANDMARKS[seen] - place
        bearing = Bearing(time, 0, 1 + taken_for, wrap(np.arctan2(y, x) - heading + rng.uniform(-ANGLE, ANGLE)), ANGLE)
        distance = Range(time, 0, 1 + taken_for, np.hypot(x, y) * rng.uniform(1 - SHARE, 1 + SHARE), 0, SHARE)
        frames.append(Frame(time, driven if k else None, (bearing, distance)))
        places.append(place)
    return frames, places


def main(seed: int = 0) -> int:
    """Follow the robot; return 0 if it was inside its region whenever this was promised."""
    frames, places = world(np.random.default_rng(seed))
    team, tolerance = Team(1, LANDMARKS, arena=[[-5, -5], [5, 5]]), Tolerance(window=2.0, suspects="identities")
    filter_ = SetMembershipFilter(team, policy="reject", tolerance=tolerance)
    belief = filter_.start(0.0, [Polygon.box([-5, -5], [5, 5])])
    inside = True
    for step, place in zip(follow(filter_, belief, frames), places, strict=True):
        belief, region = step.belief, step.belief.regions[0].outer
        inside &= bool(region.contains(place) or not belief.guarantee.in_force[0])
        heading = np.degrees(belief.headings.bound[0])
        if belief.time % 2 == 0 or belief.events:
            print(f"{belief.time:4.1f} s: {region.area:6.2f} m2, heading to {heading:.0f} degrees", *belief.events, sep="\n  ")
    print("The robot was inside all the time." if inside else "The robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
