"""Draws a fault for a world as it is: somebody is there whom it can befall, and who sees it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from experiments.broken.fault import LARGE, LASTING, OF_NAMES, SHARE_BELOW, Fault, Kind, size_drawn
from experiments.broken.scene import HALF, ROBOTS
from experiments.broken.world import World
from filter import Array

DEGREE = np.pi / 180
# The greatest sizes of each kind [m], [rad].
MOST: dict[Kind, tuple[float, float]] = {
    "slip": (1.5, 60 * DEGREE),
    "kidnap": (4.0, 180 * DEGREE),
    "start": (2.5, 60 * DEGREE),
    "compass": (0.0, 90 * DEGREE),
    "biased": (1.5, 40 * DEGREE),
    "moved": (2.0, 0.0),
}
PUT, SLID = 4.5, 5.2  # so far from either axis robots can be put down, and slide, and still turn back in the arena [m]
MOVED = 5.5  # so far landmarks can be moved [m]
TRIES = 200  # after which what does not fit is not drawn


def fault_drawn(world: World, kind: Kind, when: int) -> Fault | None:
    """Draw a fault that begins in a frame of this number, now or next; None if nobody is there whom it can befall.

    A fault of names has no size but the distance of those whose names change, which is large.
    """
    rng = world.rng
    below = kind not in OF_NAMES and bool(rng.random() < SHARE_BELOW)
    passing = {"compass": int(rng.integers(3, 11)), "misread": int(rng.integers(1, 4))}
    until = np.inf if kind in LASTING else float(when + passing.get(kind, 1))
    metres, radians = MOST.get(kind, (0.0, 0.0))
    most = metres, radians if kind != "start" or world.scene.headings else 0.0
    for _ in range(TRIES):
        size = (0.0, 0.0) if kind in OF_NAMES else size_drawn(rng, most, below=below)
        whom = DRAWN[kind](world, size)
        if whom is not None:
            robot, body, read, offset = whom
            return Fault(kind, when, until, below, robot, body, read, (float(offset[0]), float(offset[1])), size[1])
    return None


Whom = tuple[int, int, int, Array] | None  # robot, body, read, offset


def _slips(world: World, size: tuple[float, float]) -> Whom:
    robot = int(world.rng.integers(ROBOTS))
    slid = max(0.0, -size[0]) + LARGE
    ahead = world.headings[robot] + np.radians([-45, 0, 45])
    ends = world.positions[robot] + slid * np.stack([np.cos(ahead), np.sin(ahead)], axis=1)
    return (robot, -1, -1, np.array([size[0], 0.0])) if _within(ends, SLID) else None


def _is_carried(world: World, size: tuple[float, float]) -> Whom:
    robot, offset = int(world.rng.integers(ROBOTS)), _somewhere(world, size[0])
    return (robot, -1, -1, offset) if _within(world.positions[robot] + offset, PUT) else None


def _begins_elsewhere(world: World, size: tuple[float, float]) -> Whom:
    robot, axis = int(world.rng.integers(ROBOTS)), int(world.rng.integers(2))
    offset = size[0] * np.eye(2)[axis]
    box = world.positions[robot] + offset + world.scene.start * np.sign(offset)
    return (robot, -1, -1, offset) if _within(box, HALF) else None


def _reads_north_wrongly(world: World, _: tuple[float, float]) -> Whom:
    return int(world.rng.integers(ROBOTS)), -1, -1, np.zeros(2)


def _are_exchanged(world: World, _: tuple[float, float]) -> Whom:
    one, other = sorted(world.rng.choice(ROBOTS, 2, replace=False).tolist())
    third = next(robot for robot in range(ROBOTS) if robot not in {one, other})
    seen = world.seen(world.bodies())[third, [one, other]].any()
    apart = np.hypot(*(world.positions[one] - world.positions[other]))
    return (one, other, -1, np.zeros(2)) if seen and apart > 2 * LARGE else None


def _is_misread(world: World, _: tuple[float, float]) -> Whom:
    places = world.bodies()
    seen = np.argwhere(world.seen(places))
    if not len(seen):
        return None
    robot, body = (int(number) for number in world.rng.choice(seen))
    read = int(world.rng.integers(len(places)))
    apart = np.hypot(*(places[read] - places[body]))
    return (robot, body, read, np.zeros(2)) if read not in {robot, body} and apart > 2 * LARGE else None


def _looks_aside(world: World, size: tuple[float, float]) -> Whom:
    robot = int(world.rng.integers(ROBOTS))
    seen = world.seen(world.bodies())[robot, ROBOTS:].any()
    return (robot, -1, -1, np.array([size[0], 0.0])) if seen else None


def _is_moved(world: World, size: tuple[float, float]) -> Whom:
    body, offset = ROBOTS + int(world.rng.integers(len(world.scene.landmarks))), _somewhere(world, size[0])
    seen = world.seen(world.bodies())[:, body].any()
    return (-1, body, -1, offset) if seen and _within(world.bodies()[body] + offset, MOVED) else None


def _somewhere(world: World, metres: float) -> Array:
    way = world.rng.uniform(-np.pi, np.pi)
    return metres * np.array([np.cos(way), np.sin(way)])


def _within(places: Array, half: float) -> bool:
    return bool((np.abs(places) < half).all())


DRAWN: dict[Kind, Callable[[World, tuple[float, float]], Whom]] = {
    "slip": _slips,
    "kidnap": _is_carried,
    "start": _begins_elsewhere,
    "compass": _reads_north_wrongly,
    "swap": _are_exchanged,
    "misread": _is_misread,
    "biased": _looks_aside,
    "moved": _is_moved,
}
