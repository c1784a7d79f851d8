"""Small worlds in an arena for the robust filter, and what became of the truth in them."""

from dataclasses import replace

import numpy as np
from helpers.worlds import World

from filter.geometry.polygon import Polygon
from filter.robust.belief import Turned

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


def missing(belief, world):
    """Return the robots whose position or heading is outside."""
    places, headings = inside(belief, world)
    return np.flatnonzero(~(places & headings)).tolist()


def turned_in(beliefs):
    """Return the events of cameras that are suspected to be turned, or trusted again."""
    return [event for belief in beliefs for event in belief.events if isinstance(event, Turned)]
