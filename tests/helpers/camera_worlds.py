"""Small worlds in an arena whose cameras can be wrong, and what became of the truth in them."""

from dataclasses import replace

import numpy as np
from helpers.worlds import World

from filter import Bearing, Range
from filter.geometry.polygon import Polygon

ARENA = [[-3.0, -3.0], [9.0, 9.0]]
GUILTY = 1  # whose camera lies


def world_of(seed, robots=3, landmarks=5, **options):
    """Return a world in the arena."""
    world = World(np.random.default_rng(seed), robots=robots, landmarks=landmarks, sight=5.0, **options)
    world.team = replace(world.team, arena=ARENA)
    return world


def started(robust, world, known="pose"):
    """Return the first belief; known are poses, positions, or nothing but the arena."""
    sets = [Polygon.box(*ARENA)] * world.robots if known == "arena" else world.initial_sets()
    return robust.start(0.0, sets, world.initial_headings() if known == "pose" else None)


def inside(belief, world):
    """Return (n,) whether positions, and whether headings, are inside."""
    outers = [region.outer for region in belief.regions]
    places = np.array([bool(outer.contains(place)) for outer, place in zip(outers, world.positions, strict=True)])
    return places, belief.headings.contains(world.headings)


def turned(records, by):
    """Return records with the bearings of the guilty one's camera turned [rad]."""
    return [replace(r, bearing=r.bearing + by * (r.robot == GUILTY)) if isinstance(r, Bearing) else r for r in records]


def later(records, before, time):
    """Return records with those of the guilty one's camera as they were some steps before, with the time of now."""
    others, own = ([r for r in each if isinstance(r, Bearing | Range)] for each in (records, before))
    chosen = [(r, r.robot != GUILTY) for r in others] + [(r, r.robot == GUILTY) for r in own]
    return [_part(r, mask, time) for r, mask in chosen]


def _part(record, mask, time):
    columns = {name: column[mask] for name, column in vars(record).items() if isinstance(column, np.ndarray)}
    return replace(record, **columns, time=time)
