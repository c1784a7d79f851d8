"""Whatever team, sensors, place and filter: what the filter claims is proved by the checker, headings and all."""

import numpy as np
import pytest
from helpers.worlds import World

from experiments.logs import Certificates, Header, InitialSet, LogWriter, first_belief
from experiments.proof.alternatives.doubts import Cover
from experiments.proof.chain import Chain
from experiments.proof.given.log import Log
from experiments.proof.reading import Feed
from experiments.prove import HEADINGS, LINES, REGIONS, regions_of
from filter import Frame, RelativeHeading, SetMembershipFilter, Window, follow


def world_of(rng):
    """Return a world with 2 to 5 robots, up to 3 landmarks, some of it far from the origin, and sensors of any kind."""
    return World(
        rng,
        robots=int(rng.integers(2, 6)),
        landmarks=int(rng.integers(0, 4)),
        errors=rng.choice(["extreme", "uniform"]),
        origin=rng.choice([0.0, 1e4, 5e6]) + rng.uniform(-3, 3, 2),
        sight=rng.uniform(2, 9),
        compass=np.radians(rng.uniform(0.5, 8)),
        bearing=np.radians(rng.uniform(0.2, 8)),
    )


def mates(world, rng):
    """Return what some robots see of others' headings, from well to not at all."""
    robots = np.arange(len(world.headings))
    mate, bound = (robots + rng.integers(1, len(robots), len(robots))) % len(robots), rng.choice([0.02, 0.3, 2.5], len(robots))
    seen = world.headings[mate] - world.headings + bound * rng.choice([-1, 1, 0.3], len(robots))
    return RelativeHeading(world.time, robots, mate, seen, bound + 1e-9)


def frames_of(world, compasses, seeing=None):
    """Yield 7 frames; some have a mate's heading, if seen."""
    for k in range(7):
        motion, records = world.move(backwards=k % 2 == 1) if k else None, world.measure(compasses=compasses)
        records += [mates(world, seeing)] if seeing else []
        yield Frame(world.time, motion, tuple(records))


def run(path, seed):
    """Write a run's log and certificates."""
    rng = np.random.default_rng(seed)
    world, light, known, every = world_of(rng), seed % 2 == 0, seed % 3 > 0, seed % 4 == 3
    options = {"policy": "reject" if every else "raise", **({"scope": Window(1)} if seed % 5 == 0 else {})}
    options["cells"] = (0, 8, 16)[seed % 3]
    estimator = (SetMembershipFilter.light if light else SetMembershipFilter)(world.team, **options)
    arcs = world.initial_headings(1.5 if seed % 7 == 0 else 0.2)
    headings = [(float(c), float(b)) if known else None for c, b in zip(arcs.centre, arcs.bound, strict=True)]
    sets = world.initial_sets(rng.uniform(0.1, 2))
    initial = [InitialSet(one.vertices, heading) for one, heading in zip(sets, headings, strict=True)]
    seeing = np.random.default_rng(seed) if seed % 5 == 0 else None
    header = Header(world.team, 0.0, 10.0, version=2 if seeing else 1)
    belief = first_belief(estimator, header, initial)
    with LogWriter(path / "log.jsonl", header, initial) as log, Certificates(path, world.team) as file:
        for frame in frames_of(world, compasses=every or rng.uniform() < 0.5, seeing=seeing):
            log.write(frame)
            (step,) = follow(estimator, belief, [frame])
            belief = step.belief
            file.write(step)


def links_of(path):
    """Prove a run's log and certificates; return how many links of each kind there were."""
    log = Log(path)
    chain, (headings, lines, regions) = Chain(log), (Feed(path / name) for name in (HEADINGS, LINES, REGIONS))
    for frame in log.frames:
        chain.check(headings.at(frame.time), lines.at(frame.time))
        regions_of(frame, regions.at(frame.time), Cover(chain.headings, chain.shown))
    return chain.links


def test_any_run_is_proved(tmp_path_factory):
    links = {}
    for seed in (1, 3, 5, 10, 14):
        path = tmp_path_factory.mktemp("any")
        run(path, seed)
        for name, count in links_of(path).items():
            links[name] = links.get(name, 0) + count
    assert links["headings, from bearings, too"] > 50
    assert links["rows of ranges, near side, over a narrower arc that is proved"] > 50
    assert links["rows of ranges, near side, from the log"] > 0


@pytest.mark.parametrize("seed", [1, 2])
def test_the_sides_hold_for_the_truth(tmp_path, seed):
    """What the checker concludes of directions contains them: it is no proof of anything if it does not."""
    rng = np.random.default_rng(seed)
    world = World(rng, robots=3, landmarks=2, errors="extreme")
    estimator = SetMembershipFilter(world.team, cells=8)
    initial = [InitialSet(one.vertices) for one in world.initial_sets(0.2)]
    header = Header(world.team, 0.0, 10.0)
    belief, places, headings = first_belief(estimator, header, initial), [], []
    with LogWriter(tmp_path / "log.jsonl", header, initial) as log, Certificates(tmp_path, world.team) as file:
        for frame in frames_of(world, compasses=False):
            places.append(np.concatenate([world.positions, world.team.landmarks]))
            headings.append(world.headings)
            log.write(frame)
            (step,) = follow(estimator, belief, [frame])
            belief = step.belief
            file.write(step)
    given, sure = Log(tmp_path), 0
    chain, feeds = Chain(given), [Feed(tmp_path / name) for name in (HEADINGS, LINES)]
    for number, frame in enumerate(given.frames):
        chain.check(*(feed.at(frame.time) for feed in feeds))
        for robot in range(3):
            assert contains(chain.headings[robot], headings[number][robot])
            for target in set(range(5)) - {robot}:
                arc = chain.sides.arc(robot, target)
                way = places[number][target] - places[number][robot]
                assert arc is None or contains(arc, np.arctan2(way[1], way[0]))
                sure += arc is not None and arc.narrow
    assert sure > 20


def contains(arc, angle):
    """Return whether an arc contains an angle, to rounding."""
    low, high = float(arc.low) - 1e-12, float(arc.high) + 1e-12
    return any(low <= angle + 2 * np.pi * turns <= high for turns in range(-3, 4))
