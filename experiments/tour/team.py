"""A team: two robots that see no landmark know where they are, because they see the one that does.

The robots wander without odometry; all that is known of their motion is how fast they can be. Each has a compass and sees
the next one. Robot 0 sees the landmark, which is body 3 of the team.
"""

import sys

import numpy as np

from filter import Array, Bearing, Compass, Frame, Polygon, Range, SetMembershipFilter, Team, follow

LANDMARK = np.array([[0.0, 3.0]])
STARTS = np.array([[0.0, 0.0], [3.0, 0.0], [6.0, 0.0]])
SPEED, ANGLE, SHARE = 0.2, np.radians(3), 0.02  # the fastest [m/s], and the largest errors: [rad], and of a range its share


def world(rng: np.random.Generator) -> tuple[list[Frame], list[Array]]:
    """Return what the robots are given every half second, and where they really are."""
    places, headings = STARTS + rng.uniform(-0.5, 0.5, (3, 2)), np.array([1.0, 2.0, 3.0])
    who, whom = np.array([0, 1, 2]), np.array([3, 0, 1])
    frames, truths = [], []
    for time in 0.5 * np.arange(10):
        places = places + 0.5 * SPEED * rng.uniform(-0.7, 0.7, (3, 2))
        away = np.concatenate([places, LANDMARK])[whom] - places[who]
        true = np.arctan2(away[:, 1], away[:, 0]) - headings
        compass = Compass(time, who, headings + rng.uniform(-ANGLE, ANGLE, 3), ANGLE)
        bearings = Bearing(time, who, whom, true + rng.uniform(-ANGLE, ANGLE, 3), ANGLE)
        ranges = Range(time, who, whom, np.hypot(*away.T) * rng.uniform(1 - SHARE, 1 + SHARE, 3), 0, SHARE)
        frames.append(Frame(time, measurements=(compass, bearings, ranges)))
        truths.append(places)
    return frames, truths


def main(seed: int = 0) -> int:
    """Follow the team; return 0 if all robots were inside their regions all the time."""
    frames, truths = world(np.random.default_rng(seed))
    filter_ = SetMembershipFilter(Team(robots=3, landmarks=LANDMARK, speed_limit=SPEED))
    belief = filter_.start(0.0, [Polygon.box(start - 0.6, start + 0.6) for start in STARTS])
    inside = True
    print("Areas of the three regions, of which only the first robot sees the landmark:")
    for step, places in zip(follow(filter_, belief, frames), truths, strict=True):
        inside &= bool(step.belief.regions.contains(places).all())
        areas = " ".join(f"{region.outer.area:6.3f}" for region in step.belief.regions)
        print(f"{step.belief.time:.1f} s: {areas} m2")
    print("All robots were inside all the time." if inside else "A robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
