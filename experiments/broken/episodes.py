"""An episode: a team that drives, what is told of it frame by frame, and the one bound that is broken in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.broken.drawn import fault_drawn
from experiments.broken.fault import Fault, Kind
from experiments.broken.scene import Scene
from experiments.broken.world import World
from filter import AngularIntervals, Frame, Polygon, Team

BEFORE = 14  # frames before a fault
AT_ONCE = 0.25  # of bad compasses that are so from the first frame on
AFTER = (25, 30)  # frames after a fault
NEVER = Fault("slip", -1, -1.0, below=False)  # the fault of an episode in which every bound holds


@dataclass(frozen=True, eq=False)
class Episode:
    """What a filter is given, and what is wrong with it.

    Attributes:
        scene: Where it takes place.
        fault: What is wrong; `NEVER` if nothing is.
        positions: (n) boxes in which the robots begin [m].
        headings: Arcs of their headings then, or None where nobody knows [rad].
        frames: All of them, with the truth; the first one is at time 0, without odometry.
    """

    scene: Scene
    fault: Fault
    positions: tuple[Polygon, ...]
    headings: AngularIntervals | None
    frames: tuple[Frame, ...]

    @property
    def team(self) -> Team:
        """The robots and the landmarks, as a filter knows them."""
        return self.scene.team

    @classmethod
    def drawn(cls, rng: np.random.Generator, kind: Kind | None, landmarks: int = 4) -> Episode:
        """Draw an episode; the same generator, the same episode.

        A fault begins after `BEFORE` frames, as soon as it can befall somebody.

        Args:
            rng: Where all randomness comes from.
            kind: Of its fault; None for an episode in which every bound holds.
            landmarks: How many there are; 4 and more are all in view.

        Raises:
            InvalidInput: There are too few landmarks, or too many.
        """
        while (episode := cls._tried(rng, kind, landmarks)) is None:
            pass
        return episode

    @classmethod
    def _tried(cls, rng: np.random.Generator, kind: Kind | None, landmarks: int) -> Episode | None:
        """Draw an episode; None if there was nobody whom its fault can befall."""
        scene = Scene.drawn(rng, landmarks, compass=kind == "compass")
        world = World.drawn(scene, rng)
        at_once = kind == "start" or (kind == "compass" and bool(rng.random() < AT_ONCE))
        fault = fault_drawn(world, kind, 0) if kind and at_once else None
        positions, headings = world.begun(fault or NEVER)
        frames, after = [world.told(fault or NEVER)], int(rng.integers(AFTER[0], AFTER[1] + 1))
        while len(frames) < (fault.settled if fault else BEFORE) + after:
            if kind and not fault and len(frames) >= BEFORE:
                fault = fault_drawn(world, kind, len(frames))
            frames.append(world.driven(fault or NEVER))
        return None if kind and not fault else cls(scene, fault or NEVER, positions, headings, tuple(frames))
