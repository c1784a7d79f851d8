"""Where the walls and beacons stand and where each robot is at home; no physics yet.

Six robots share one tile of 12 m x 8 m: three rooms in a row, joined by wide openings. One beacon stands in the left room
and can hardly be seen from elsewhere. The six home zones overlap along the chain left - middle - right, so knowledge of
the beacon reaches the right room only from robot to robot. Larger teams get more tiles of the same kind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter import Array, InvalidInput, Mask
from sim.geometry import distance_to_wall

TILE = np.array([12.0, 8.0])  # [m]
WALL_THICKNESS = 0.1  # [m]
BEACON = np.array([-4.8, -1.6])  # [m] from the tile's middle
START_CLEARANCE = 0.45  # [m] from a starting robot's axle to a wall, a beacon or half-way to another robot
ATTEMPTS = 10_000

# Walls inside a tile as x, y, x, y of their ends [m].
INNER_WALLS = np.array(
    [
        [-2.0, -4.0, -2.0, -1.0],
        [-2.0, 2.0, -2.0, 4.0],
        [2.0, -4.0, 2.0, -2.0],
        [2.0, 1.0, 2.0, 4.0],
        [-6.0, 1.4, -4.8, 1.4],
        [0.0, 2.6, 0.0, 4.0],
        [4.6, 0.4, 6.0, 0.4],
    ]
)
# Between one tile and the next: a wall with an opening; those from tile to tile in y join the rooms without beacons.
RIGHT_WALLS = np.array([[6.0, -4.0, 6.0, -1.5], [6.0, 1.5, 6.0, 4.0]])
TOP_WALLS = np.array([[-6.0, 4.0, 2.6, 4.0], [5.4, 4.0, 6.0, 4.0]])

# Home zones as x, y, x, y of two corners [m]; from the beacon's room to the one that never sees it.
HOMES = np.array(
    [
        [-5.6, -3.6, -2.4, 1.0],
        [-4.6, -0.6, -0.6, 3.4],
        [-3.0, -3.4, 1.0, 2.2],
        [-1.0, -2.6, 3.0, 3.0],
        [0.6, -3.4, 4.6, 2.6],
        [2.4, -3.6, 5.6, 3.6],
    ]
)


@dataclass(frozen=True, eq=False)
class Layout:
    """An arena for a team.

    Attributes:
        arena: (2, 2) lower and upper corner of the box inside the outer walls [m].
        walls: (w, 4) lower x, lower y, upper x, upper y of each wall [m], the outer ones included.
        beacons: (l, 2) positions of the landmarks [m].
        homes: (n, 4) lower x, lower y, upper x, upper y of each robot's home zone [m].
    """

    arena: Array
    walls: Array
    beacons: Array
    homes: Array


def layout(robots: int) -> Layout:
    """Return the arena for a team of `robots` robots, around the origin: one tile for every six robots begun.

    Raises:
        InvalidInput: There is no robot.
    """
    if not isinstance(robots, int | np.integer) or robots < 1:
        raise InvalidInput("a whole number of robots from 1 on", f"{robots!r} robots")
    tiles = -(-int(robots) // len(HOMES))
    columns, rows = _grid(tiles)
    half = TILE * [columns, rows] / 2
    middles = np.array([TILE * [c, r] - half + TILE / 2 for r in range(rows) for c in range(columns)])
    lines = [_outer_lines(half)]
    for index, middle in enumerate(middles):
        lines.append(_tile_lines(index % columns < columns - 1, index // columns < rows - 1) + np.tile(middle, 2))
    homes = np.concatenate([HOMES + np.tile(middle, 2) for middle in middles[:tiles]])[:robots]
    return Layout(np.array([-half, half]), _thick(np.concatenate(lines)), BEACON + middles[:tiles], homes)


def _grid(tiles: int) -> tuple[int, int]:
    """Return columns and rows of the grid of least circumference that holds the tiles."""
    grids = [(columns, -(-tiles // columns)) for columns in range(1, tiles + 1)]
    return min(grids, key=lambda grid: TILE @ grid)


def _tile_lines(right: bool, top: bool) -> Array:
    return np.concatenate([INNER_WALLS, RIGHT_WALLS[: 2 * right], TOP_WALLS[: 2 * top]])


def _outer_lines(half: Array) -> Array:
    x, y = half + WALL_THICKNESS / 2  # the arena is what the inner faces enclose
    return np.array([[-x, -y, x, -y], [-x, y, x, y], [-x, -y, -x, y], [x, -y, x, y]])


def _thick(lines: Array) -> Array:
    return lines + WALL_THICKNESS / 2 * np.array([-1, -1, 1, 1])


def start_poses(plan: Layout, generator: np.random.Generator) -> tuple[Array, Array]:
    """Return (n, 2) positions [m] and (n,) headings [rad] drawn in the home zones, clear of walls and of one another.

    Raises:
        InvalidInput: A zone is too crowded for another robot.
    """
    taken = plan.beacons
    for home in plan.homes:
        around = home + 2 * START_CLEARANCE * np.array([-1, -1, 1, 1])
        bodies = taken[_meet(np.tile(taken, 2), around)]
        place = _free_place(home, bodies, plan.walls[_meet(plan.walls, around)], generator)
        taken = np.concatenate([taken, place[None]])
    headings = generator.uniform(-np.pi, np.pi, len(plan.homes))
    return taken[len(plan.beacons) :], headings


def _meet(rectangles: Array, other: Array) -> Mask:
    """Return (k,), whether each of the (k, 4) rectangles has a point in another."""
    return np.asarray(((rectangles[:, :2] <= other[2:]) & (other[:2] <= rectangles[:, 2:])).all(axis=1))


def _free_place(home: Array, taken: Array, walls: Array, generator: np.random.Generator) -> Array:
    """Return a place in a zone, clear of the bodies and walls around it."""
    for _ in range(ATTEMPTS):
        place = generator.uniform(home[:2], home[2:])
        apart = np.linalg.norm(taken - place, axis=1) >= 2 * START_CLEARANCE
        if apart.all() and (distance_to_wall(place, walls) >= START_CLEARANCE).all():
            return place
    raise InvalidInput("a home zone with room for one more robot", f"zone {home.tolist()}")
