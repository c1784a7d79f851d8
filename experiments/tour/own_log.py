"""An own log: what an own robot measured is written to a file, read back, and followed.

The file is one JSON object a line; docs/log.md has its form. Any program can write it, and the experiments read it:
`python -m experiments.moving_team --replay log.jsonl`.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from experiments.logs import Header, InitialSet, LogReader, LogWriter, first_belief
from filter import Bearing, Compass, Frame, Odometry, SetMembershipFilter, Team, Truth, follow

TEAM = Team(robots=1, landmarks=[[3.0, 2.0]])
START = InitialSet(np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]), heading=(0.0, 0.1))
ANGLE = np.radians(2)  # the largest error of compass and bearings [rad]


def write(path: Path, rng: np.random.Generator) -> None:
    """Log a robot that drives straight on, past the landmark: what it measures, and where it really is."""
    begin, ahead = rng.uniform(-0.5, 0.5, 2), np.array([0.2, 0.0])
    with LogWriter(path, Header(TEAM, start=0.0, rate=4.0), [START]) as log:
        for k in range(24):
            time, place, said = 0.25 * k, begin + k * ahead, 0.2 + rng.uniform(-0.01, 0.01)
            driven = Odometry(time - 0.25, time, 0, said, 0.01, turn=0, turn_bound=0.01, direction_bound=0.01, slip_bound=0.001)
            compass = Compass(time, 0, rng.uniform(-ANGLE, ANGLE), ANGLE)
            x, y = TEAM.landmarks[0] - place
            bearing = Bearing(time, 0, 1, np.arctan2(y, x) + rng.uniform(-ANGLE, ANGLE), ANGLE)
            log.write(Frame(time, driven if k else None, (compass, bearing), Truth(place[None], np.zeros(1))))


def main(seed: int = 0) -> int:
    """Write a log, read it, follow it; return 0 if the robot was inside its region all the time."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.jsonl"
        write(path, np.random.default_rng(seed))
        print("The log has lines such as", *path.read_text().splitlines()[1:4], sep="\n  ")
        log = LogReader(path)
        filter_ = SetMembershipFilter(log.header.team)
        steps = list(follow(filter_, first_belief(filter_, log.header, log.initial), log.frames()))
    inside = all(step.belief.regions.contains(step.frame.truth.positions).all() for step in steps if step.frame.truth)
    first, last = (steps[k].belief.regions[0].outer.area for k in (0, -1))
    print(f"In {len(steps)} steps the region went from {first:.3f} to {last:.3f} m2.")
    print("The robot was inside all the time." if inside else "The robot was outside!")
    return int(not inside)


if __name__ == "__main__":
    sys.exit(main())
