"""Scenarios from the simulator."""

from __future__ import annotations

from experiments.following.scenarios import CORNERS, Scenario
from experiments.logs import Header, InitialSet
from sim.episode import Episode
from sim.world import World


def from_simulator(episode: Episode, rate: float) -> Scenario:
    """Return the scenario of a simulated episode; the headings at its start are unknown."""
    boxes = episode.start_centres[:, None] + episode.start_bound * CORNERS
    world = episode.world
    return Scenario(
        header=Header(episode.team, 0.0, rate),
        initial=tuple(InitialSet(box) for box in boxes),
        frames=episode,
        count=len(episode),
        walls=world.walls,
        wall_height=world.wall_height,
        picture=world.render if isinstance(world, World) else None,
    )
