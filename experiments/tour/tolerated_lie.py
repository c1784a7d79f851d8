"""A tolerated lie: radio that goes around a wall is too long, contradicts nothing, and the robot is inside all the same.

A robot drives among five radio anchors. For a while a wall is in the way to one of them, and that range is a little too long:
in conflict with nothing, so that a filter that only goes on after conflicts loses the robot, and does not know. The other one
tolerates that ranges to one anchor are too long: its region is two or three times as large.
"""

import sys

import numpy as np

from filter import Frame, Odometry, Polygon, Range, SetMembershipFilter, Team, Tolerance, Truth, follow

ANCHORS = np.array([[5.0, 0.0], [1.5, 4.8], [-4.0, 2.9], [-4.0, -2.9], [1.5, -4.8]])
LENGTH, SLIP = 0.1, 0.01  # the largest errors of a range and of a step, as is promised [m]
WALL, LONGER = range(6, 16), 0.06  # when the first anchor is behind a wall, and how much longer the way around it is [s] [m]
END, SELDOM = 24, 6  # when all ends, and how seldom something is said [s]


def world(rng: np.random.Generator) -> list[Frame]:
    """Return what the robot is given every second, as it drives along a circle."""
    frames = []
    for time in range(END):
        place, heading = np.array([np.sin(0.2 * time), -np.cos(0.2 * time)]), 0.2 * time
        ranges = np.hypot(*(ANCHORS - place).T) + rng.uniform(-LENGTH, LENGTH, len(ANCHORS))
        ranges[0] += LONGER if time in WALL else 0.0
        record = Range(time, np.zeros(5, dtype=int), np.arange(1, 6), ranges, LENGTH, relative_bound=0)
        odometry = Odometry(time - 1.0, time, 0, 0.2, SLIP, 0.2, SLIP, SLIP, SLIP) if time else None
        frames.append(Frame(time, odometry, (record,), Truth(place[None], np.array([heading]))))
    return frames


def lost(filter_: SetMembershipFilter, seed: int) -> int:
    """Follow the robot, and return for how many seconds it was outside though the guarantee was in force."""
    count, belief = 0, filter_.start(0.0, [Polygon.box([-1, -2], [1, 0])])
    for step in follow(filter_, belief, world(np.random.default_rng(seed))):
        belief, place = step.belief, step.frame.truth.positions[0] if step.frame.truth else np.zeros(2)
        count += not belief.regions[0].outer.contains(place)
        if belief.events or belief.time % SELDOM == 0:
            print(f"{belief.time:.0f} s: {belief.regions[0].outer.area:.3f} m2", *belief.events, sep="\n     ")
    print(f"Outside for {count} s. The guarantee is {belief.guarantee}.")
    return count


def main(seed: int = 0) -> int:
    """Follow the robot twice; return 0 if the filter that tolerates the lie never lost it."""
    team = Team(robots=1, landmarks=ANCHORS, speed_limit=0.5, turn_rate_limit=0.5)
    lost(SetMembershipFilter(team, policy="reject"), seed)
    count = lost(SetMembershipFilter(team, tolerance=Tolerance(lies="long")), seed)
    print("With the tolerance the robot was " + ("outside!" if count else "inside all the time."))
    return int(count > 0)


if __name__ == "__main__":
    sys.exit(main())
