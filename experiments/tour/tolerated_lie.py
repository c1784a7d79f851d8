"""A tolerated lie: radio that goes around a wall is too long, contradicts nothing, and the robot is inside all the same.

A robot drives among five radio anchors, with wheels that tell how far. For a while the way to one of the anchors is blocked by
a wall, and its range is too long by a little. That is in conflict with nothing, so the filter that believes everything loses
the robot, and does not know. The other one tolerates that ranges to one anchor are too long: its region is two or three times as
large, and the robot is inside.
"""

import sys
from collections.abc import Iterator

import numpy as np

from filter import Array, Frame, Inconsistent, Odometry, Polygon, Range, SetMembershipFilter, Team, Tolerance, Truth, follow

ANCHORS = np.array([[5.0, 0.0], [1.5, 4.8], [-4.0, 2.9], [-4.0, -2.9], [1.5, -4.8]])
LENGTH, SLIP = 0.1, 0.01  # the largest errors of a range and of a step, as is promised [m]
WALL, LONGER = range(6, 16), 0.06  # when the first anchor is behind a wall, and how much longer the way around it is [s] [m]
END, SELDOM = 24, 3  # [s]


def world(rng: np.random.Generator) -> Iterator[Frame]:
    """Yield what the robot is given every second, as it drives along a circle."""
    place, heading = np.array([0.0, -1.0]), 0.0
    for time in range(END):
        odometry = None
        if time:
            odometry = Odometry(time - 1.0, time, 0, 0.2, SLIP, 0.2, SLIP, SLIP, SLIP)
            place, heading = place + 0.2 * np.sinc(0.1 / np.pi) * towards(heading + 0.1), heading + 0.2
        ranges = np.hypot(*(ANCHORS - place).T) + rng.uniform(-LENGTH, LENGTH, len(ANCHORS))
        ranges[0] += LONGER if time in WALL else 0.0
        record = Range(time, [0] * len(ANCHORS), range(1, 1 + len(ANCHORS)), ranges, LENGTH, relative_bound=0)
        yield Frame(time, odometry, (record,), Truth(place[None], np.array([heading])))


def towards(angle: float) -> Array:
    """Return a unit vector."""
    return np.array([np.cos(angle), np.sin(angle)])


def lost(filter_: SetMembershipFilter, seed: int) -> int:
    """Follow the robot, and return at how many seconds it was outside though the guarantee was in force."""
    count, belief = 0, filter_.start(0.0, [Polygon.box([-1, -2], [1, 0])])
    print(f"The guarantee is {belief.guarantee}.")
    try:
        for step in follow(filter_, belief, world(np.random.default_rng(seed))):
            belief, truth = step.belief, step.frame.truth
            region = belief.regions[0].outer
            inside = truth is not None and bool(region.contains(truth.positions[0]))
            count += not inside
            if belief.events or not inside or belief.time % SELDOM == 0:
                print(
                    f"{belief.time:3.0f} s: {region.area:.3f} m2{'' if inside else ', OUTSIDE'}",
                    *belief.events,
                    sep="\n       ",
                )
    except Inconsistent as error:
        print(f"     The filter stops: {error}")
    return count


def main(seed: int = 0) -> int:
    """Follow the robot twice; return 0 if the filter that tolerates the lie never lost it."""
    team = Team(robots=1, landmarks=ANCHORS, speed_limit=0.5, turn_rate_limit=0.5)
    believing = lost(SetMembershipFilter(team), seed)
    tolerant = lost(SetMembershipFilter(team, tolerance=Tolerance(lies="long")), seed)
    print(f"Outside for {believing} s where every range is believed, for {tolerant} s where one anchor's may be too long.")
    return int(tolerant > 0)


if __name__ == "__main__":
    sys.exit(main())
