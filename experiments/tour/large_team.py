"""A large team: eighty robots, each found from those near it, in time.

`light` takes less along from step to step, a `Window` finds a region from what the robot would hear over a radio, and a
`Budget` ends an update in time: whoever was not reached keeps the region that was known anyway. Regions are larger for it,
and no less sure.
"""

import sys
from time import perf_counter

import numpy as np

from filter import Array, Bearing, Budget, Compass, Frame, Polygon, Range, SetMembershipFilter, Team, Window, follow

ROBOTS = 80
GRID = 3.0 * np.stack(np.divmod(np.arange(ROBOTS), 10), axis=1)  # where they begin, more or less [m]
LANDMARKS = GRID[::7] + np.array([0.0, 1.5])
SPEED, ANGLE, SHARE = 0.1, np.radians(3), 0.05  # the fastest [m/s], and the largest errors: [rad], and of a range its share


def world(rng: np.random.Generator) -> tuple[list[Frame], list[Array]]:
    """Return what the robots are given every half second, as they wander, and where they really are."""
    places, headings = GRID + rng.uniform(-0.5, 0.5, (ROBOTS, 2)), rng.uniform(-np.pi, np.pi, ROBOTS)
    frames, truths = [], []
    for time in 0.5 * np.arange(10):
        places = places + 0.5 * SPEED * rng.uniform(-0.7, 0.7, (ROBOTS, 2))
        x, y = np.moveaxis(np.concatenate([places, LANDMARKS]) - places[:, None], 2, 0)
        who, whom = np.nonzero((np.hypot(x, y) > 0) & (np.hypot(x, y) < 3.5))  # what is near is seen
        x, y, count = x[who, whom], y[who, whom], len(who)
        compass = Compass(time, np.arange(ROBOTS), headings + rng.uniform(-ANGLE, ANGLE, ROBOTS), ANGLE)
        bearings = Bearing(time, who, whom, np.arctan2(y, x) - headings[who] + rng.uniform(-ANGLE, ANGLE, count), ANGLE)
        ranges = Range(time, who, whom, np.hypot(x, y) * rng.uniform(1 - SHARE, 1 + SHARE, count), 0, SHARE)
        frames.append(Frame(time, measurements=(compass, bearings, ranges)))
        truths.append(places)
    return frames, truths


def main(seed: int = 0) -> int:
    """Follow the team; return 0 if all robots were inside their regions all the time."""
    frames, truths = world(np.random.default_rng(seed))
    team = Team(ROBOTS, LANDMARKS, speed_limit=SPEED)
    filter_ = SetMembershipFilter.light(team, scope=Window(hops=1), budget=Budget(1.0, perf_counter))
    belief = filter_.start(0.0, [Polygon.box(place - 1, place + 1) for place in GRID])
    inside = True
    for step, places in zip(follow(filter_, belief, frames, perf_counter), truths, strict=True):
        regions = step.belief.regions
        inside &= bool(regions.contains(places).all())
        print(f"{step.belief.time:.1f} s: {regions.outer.areas.mean():.2f} m2 a robot, found in {step.seconds:.2f} s")
    print(f"All {ROBOTS} robots were inside all the time." if inside else "A robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
