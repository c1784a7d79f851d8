"""Makes small runs in the MRCLAM data set's format, of robots whose truth, commands and errors are known."""

from dataclasses import dataclass

import numpy as np

LANDMARKS = {6: (2.0, 3.0), 7: (-2.0, 3.5), 8: (-2.5, -3.0), 9: (2.5, -2.0)}
BARCODE = {1: 5, 2: 14, 3: 41, 6: 72, 7: 27, 8: 54, 9: 70}
CLOCK = 1_248_444_000.0  # what the logs' clocks show at the run's start [s]
HEAD = "# a run\n# made up\n# Data Format:\n#   columns\n"
TRUTH_STEP = 0.02


@dataclass(frozen=True)
class Made:
    """How a run is made: errors of its sensors, delays of its clocks."""

    robots: int = 2
    duration: float = 8.0
    every: float = 0.5
    delay: float = 0.04
    lag: float = 0.18
    scale: float = 0.93
    bearing_bias: float = 0.0
    range_scale: float = 1.0
    bearing_error: float = 0.03
    range_error: float = 0.10
    apart: float = 1.0
    seed: int = 0


def write_run(folder, made=None):
    """Write a run's files; return the folder."""
    made = made or Made()
    folder.mkdir(exist_ok=True)
    generator = np.random.default_rng(made.seed)
    table(folder / "Barcodes.dat", list(BARCODE.items()), "{:3d} \t {:3d}")
    table(folder / "Landmark_Groundtruth.dat", [(k, x, y, 1e-4, 1e-4) for k, (x, y) in LANDMARKS.items()])
    clock = np.arange(0.0, made.duration + 1.0, TRUTH_STEP)
    commands = {robot: commands_of(robot, made, generator) for robot in range(1, made.robots + 1)}
    truth = {robot: driven(robot, commands[robot], clock, made) for robot in commands}
    for robot, told in commands.items():
        table(folder / f"Robot{robot}_Odometry.dat", stamped(told))
        table(folder / f"Robot{robot}_Groundtruth.dat", stamped(np.column_stack([clock, truth[robot]])))
        table(folder / f"Robot{robot}_Measurement.dat", stamped(seen(robot, truth, clock, made, generator)))
    return folder


def table(path, rows, form=None):
    """Write rows in the data set's way: blanks and tabs."""
    lines = (form.format(*row) if form else " \t ".join(f"{value:.6f}" for value in row) for row in rows)
    path.write_text(HEAD + "".join(f" {line}\n" for line in lines))


def stamped(rows):
    return np.column_stack([CLOCK + rows[:, 0], rows[:, 1:]])


def commands_of(robot, made, generator):
    """Commands of a robot every 0.05 s or so, another way every second; all stamps in milliseconds."""
    times = np.unique(np.round(np.cumsum(np.append(0.0, generator.uniform(0.03, 0.07, int(made.duration / 0.05) + 20))), 3))
    ways = [(0.08, 0.0), (0.07, 0.4), (0.0, -0.3), (0.06, 0.2)]
    return np.array([(time, *ways[(int(time) + robot) % len(ways)]) for time in times])


def driven(robot, commands, clock, made):
    """Return (k, 3) x, y, heading of a robot that obeys its commands a lag later."""
    pose = np.array([0.3 * robot * made.apart, -0.4 * robot * made.apart, 0.5 * robot])
    poses, fine = [pose.copy()], 4
    for begin in clock[:-1]:
        for part in range(fine):
            time = begin + part * TRUTH_STEP / fine - made.lag
            last = np.searchsorted(commands[:, 0], time, side="right") - 1
            v, w = commands[last, 1:] if last >= 0 else (0.0, 0.0)
            step = TRUTH_STEP / fine
            way, path = pose[2] + w * step / 2, made.scale * v * step
            pose = np.array([pose[0] + path * np.cos(way), pose[1] + path * np.sin(way), pose[2] + w * step])
        poses.append(pose.copy())
    found = np.array(poses)
    found[:, 2] = np.angle(np.exp(1j * found[:, 2]))
    return found


def seen(robot, truth, clock, made, generator):
    """Return (m, 4) time, barcode, range, bearing: every landmark and every other robot, made a delay before its stamp."""
    rows = []
    for time in np.arange(made.every + 0.013 * robot, made.duration, made.every):
        poses = {k: [np.interp(time, clock, column) for column in np.unwrap(truth[k], axis=0).T] for k in truth}
        for subject in [*LANDMARKS, *(k for k in truth if k != robot)]:
            x, y = LANDMARKS.get(subject) or poses[subject][:2]
            dx, dy = x - poses[robot][0], y - poses[robot][1]
            distance = made.range_scale * np.hypot(dx, dy) + made.range_error * generator.uniform(-1, 1)
            bearing = np.arctan2(dy, dx) - poses[robot][2] + made.bearing_bias + made.bearing_error * generator.uniform(-1, 1)
            rows.append((round(time + made.delay, 3), BARCODE[subject], distance, np.angle(np.exp(1j * bearing))))
    return np.array(rows)
