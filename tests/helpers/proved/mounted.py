"""Runs of teams whose sensors are mounted somewhere, with certificates."""

import json
from dataclasses import replace

import numpy as np
from helpers.sensing.mounted import MountedWorld

from experiments.follow import main
from experiments.logs import Header, InitialSet, LogWriter
from filter import Frame, Truth


def logged(path, world, *, frames=4, known=True, wide=0.3, placed=0.0, mates=False):
    """Write the log of some frames of a world, of headings that are known at the start or not; return its path.

    A share of the antennas is placed somewhere in each frame; robots see how mates look, or not.
    """
    sets, headings = world.initial(wide, 0.2)
    arcs = zip(headings.centre.tolist(), headings.bound.tolist(), strict=True)
    initial = [InitialSet(one.vertices, arc if known else None) for one, arc in zip(sets, arcs, strict=True)]
    with LogWriter(path / "given.jsonl", Header(world.team, 0.0, 10.0), initial) as log:
        for k in range(frames):
            motion = world.drive((k - 1) / 10, k / 10) if k else None
            records = [*world.measure(k / 10), *(world.placed(k / 10, placed) if placed else [])]
            records += [world.mates(k / 10)] if mates else []
            log.write(Frame(k / 10, motion, records, Truth(world.positions, world.headings)))
    return path / "given.jsonl"


def followed(path, seed, *options, world=None, **how):
    """Return the folder of a run with certificates, of a world that a seed makes or of another."""
    path.mkdir(exist_ok=True)
    drawn = MountedWorld(np.random.default_rng(seed), robots=2 + seed % 2)
    log = logged(path, world or drawn, **how)
    assert main([str(log), "--certificates", "--out", str(path / "run"), *options]) == 0
    told = json.loads((path / "run/summary.json").read_text())
    assert told["checks"] > 0
    assert told["escapes"] == told["heading_escapes"] == 0
    return path / "run"


def moved_by(world, origin):
    """Move a world, with all that is in it, far from the origin (2,) [m]; return it."""
    world.positions = world.positions + origin
    world.team = replace(world.team, landmarks=world.team.landmarks + origin, arena=world.team.arena + origin)
    return world
