"""Folders of short runs with certificates, and what is in them."""

import gzip
import json

import numpy as np
from helpers.worlds import World

from experiments.logs import Header, InitialSet, LogWriter
from experiments.moving_team import main as moving_team
from experiments.prove import HEADINGS, LINES, REGIONS
from filter import Frame, Odometry, Truth

FILES = (LINES, HEADINGS, REGIONS)


def run_of(path, *, light=True, steps=8, **options):
    """Return the folder of a run of so many steps, some of them backwards, one robot now and then without odometry.

    Its first headings are unknown but for a compass, which only some frames have: bearings make them narrower. A light filter
    has few cells, so it is soon proved.
    """
    world = World(np.random.default_rng(0), robots=3, errors="extreme", **options)
    initial = [InitialSet(one.vertices, None) for one in world.initial_sets()]
    with LogWriter(path / "given.jsonl", Header(world.team, 0.0, 10.0), initial) as log:
        for k in range(steps):
            motion = world.move(backwards=k % 2 == 1) if k else None
            if motion is not None and k % 3 == 0:
                names = [name for name in Odometry.__dataclass_fields__ if name not in ("start", "time")]
                motion = Odometry(motion.start, motion.time, **{name: getattr(motion, name)[1:] for name in names})
            log.write(
                Frame(world.time, motion, tuple(world.measure(compasses=k % 4 == 0)), Truth(world.positions, world.headings))
            )
    folder = path / "run"
    how = ["--certificates", *(["--light"] if light else [])]
    assert moving_team(["--replay", str(path / "given.jsonl"), *how, "--out", str(folder)]) == 0
    return folder


def lines_of(folder, name=LINES):
    """Return the records of a file of a run."""
    path = folder / name
    text = gzip.decompress(path.read_bytes()).decode() if path.suffix == ".gz" else path.read_text()
    return [json.loads(line) for line in text.splitlines()]


def rewritten(folder, lines, name=LINES):
    """Write other records into a file of a run."""
    text = "".join(json.dumps(line) + "\n" for line in lines).encode()
    (folder / name).write_bytes(gzip.compress(text, 1) if name.endswith(".gz") else text)


def forge(folder, name, change):
    """Have the records of a file of a run changed."""
    lines = lines_of(folder, name)
    change(lines)
    rewritten(folder, lines, name)


def moved(text, by):
    """Return a number as a C99 hexadecimal string, changed by so much."""
    return (float.fromhex(text) + by).hex()
