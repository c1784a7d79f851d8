"""Two robots drive for a minute in the kinematic world; where they are is known at every nanosecond."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter import Array
from sim.drive import Driver
from sim.kinematic import KinematicWorld
from sim.layout import layout, start_poses
from sim.sensors import Sensors
from sim.world import TIMESTEP

STEP = round(TIMESTEP * 1e9)  # [ns]


@dataclass(frozen=True, eq=False)
class Drive:
    """Where robots were. Between two timesteps of the simulator they go straight, and turn evenly: that is the truth.

    Attributes:
        positions: (k, n, 2) at every timestep [m].
        headings: (k, n) yaws, not wrapped [rad].
        walls: (w, 4) lower x, lower y, upper x, upper y [m].
        beacon: (2,) where the beacon stands [m].
        arena: (2, 2) lower and upper corner [m].
        mast_radius: Radius of what hides others [m].
    """

    positions: Array
    headings: Array
    walls: Array
    beacon: Array
    arena: Array
    mast_radius: float

    def at(self, time: int) -> tuple[Array, Array]:
        """Return (n, 2) positions [m] and (n,) headings, not wrapped [rad], at a time since the start [ns]."""
        step, share = time // STEP, time % STEP / STEP
        first, last = self.positions[step], self.positions[step + 1]
        return first + share * (last - first), self.headings[step] + share * (self.headings[step + 1] - self.headings[step])


def drive(robots: int, duration: int, generator: np.random.Generator) -> Drive:
    """Return how robots drove for so many seconds."""
    placing, slipping, wandering = generator.spawn(3)
    plan = layout(robots)
    world = KinematicWorld(plan, *start_poses(plan, placing), sensors=Sensors(), errors="uniform", generator=slipping)
    driver, places, headings = Driver(world, wandering), [world.positions()], [world.headings()]
    for _ in range(round(duration / TIMESTEP)):
        driver.advance(1)
        places.append(world.positions())
        headings.append(world.headings())
    unwrapped = np.unwrap(np.array(headings), axis=0)
    return Drive(np.array(places), unwrapped, plan.walls, plan.beacons[0], plan.arena, world.mast_radius)
