"""Folders of runs in which something is in doubt, with certificates, and the verdict on them."""

import json
from dataclasses import replace

import numpy as np
from helpers.drawn.broken import drawn, going_on
from helpers.worlds import World

from experiments.logs import Certificates, Header, InitialSet, LogWriter, first_belief
from experiments.proof.alternatives.doubts import Doubts
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken, Feed
from experiments.proof.share import Share
from experiments.prove import ALTERNATIVES, HEADINGS, LINES, REGIONS, regions_of
from filter import Bearing, Compass, Frame, SetMembershipFilter, follow

FEEDS = (HEADINGS, LINES, ALTERNATIVES, REGIONS)
FIRST, FRAMES = 3, 6  # the frame at which a lie begins, and how many frames there are
LIES = {Bearing: 0.8, Compass: 0.6}  # how far robot 0 is off [rad], with its bearing of one landmark at once or all the time


def written(path, filter_, header, initial, frames):
    """Write log and certificates of frames; return the belief after each."""
    belief, found = first_belief(filter_, header, initial), []
    with LogWriter(path / "log.jsonl", header, initial) as log, Certificates(path, header.team) as file:
        for frame in frames:
            log.write(frame)
            (step,) = follow(filter_, belief, [frame])
            belief = step.belief
            found.append(belief)
            file.write(step)
    return found


def followed(path, kind, landmarks, count, cells, *, each_alone=True):
    """Write log and certificates of an episode, up to so many frames; return it, and the belief after each."""
    episode = drawn(kind, 3, landmarks)
    arcs = episode.headings
    heads = [None] * 3 if arcs is None else list(zip(arcs.centre.tolist(), arcs.bound.tolist(), strict=True))
    initial = [InitialSet(one.vertices, head) for one, head in zip(episode.positions, heads, strict=True)]
    header = Header(episode.team, 0.0, 1.0)
    filter_ = going_on(episode.team, cells=cells, each_alone=each_alone)
    return episode, written(path, filter_, header, initial, episode.frames[:count])


def lied(path, about, arena=(-4.0, 10.0)):
    """Write those of a small team, of which one robot is off with a kind of reading; return the beliefs."""
    world = World(np.random.default_rng(0), robots=2, landmarks=3, sight=20.0)
    world.team = replace(world.team, arena=np.outer(arena, [1, 1]))
    arcs, sets = world.initial_headings(0.2), world.initial_sets()
    heads = zip(arcs.centre.tolist(), arcs.bound.tolist(), strict=True)
    initial = [InitialSet(one.vertices, head) for one, head in zip(sets, heads, strict=True)]
    filter_ = SetMembershipFilter.light(world.team, policy="reject", cells=0, each_alone=True)
    return written(path, filter_, Header(world.team, 0.0, 10.0), initial, _frames(world, about))


def _frames(world, about):
    for k in range(FRAMES):
        motion = world.move() if k else None
        lies = k == FIRST if about is Bearing else k >= FIRST
        records = [_off(record) if lies and isinstance(record, about) else record for record in world.measure()]
        yield Frame(world.time, motion, tuple(records))


def _off(record):
    if isinstance(record, Compass):
        off = np.where(record.robot == 0, LIES[Compass], 0)
        return Compass(record.time, record.robot, record.heading + off, record.bound)
    off = np.where((record.robot == 0) & (record.target == 2), LIES[Bearing], 0)
    return Bearing(record.time, record.robot, record.target, record.bearing + off, record.bound)


def proved(path, share=None):
    """Prove a run's regions, or a share of it; return what is taken for granted, and how many links of each kind there were."""
    log, share = Log(path), share or Share()
    doubts, feeds = Doubts(log, share), [Feed(path / name) for name in FEEDS]
    for frame in log.frames:
        least = (int(name != ALTERNATIVES) for name in FEEDS)
        headings, lines, others, regions = (feed.at(frame.time, some) for feed, some in zip(feeds, least, strict=True))
        cover = doubts.check(headings, lines, others)
        regions_of(frame, regions, cover, is_proved=share.has_next())
    for feed in feeds:
        feed.end()
    return doubts.assumed, doubts.main.links


def refusal(path):
    """Return why a run is not proved, or "" if it is."""
    try:
        proved(path)
    except Broken as error:
        return str(error)
    return ""


def read_back(path, episode, frames):
    """Return frames as the checker reads them from a log."""
    initial = [InitialSet(one.vertices) for one in episode.positions]
    with LogWriter(path / "log.jsonl", Header(episode.team, 0.0, 1.0), initial) as log:
        for frame in frames:
            log.write(frame)
    return Log(path).frames


def said(frame):
    """Return what was measured in a frame of the checker, in any order."""
    readings = {who: sorted(map(str, several)) for who, several in frame.readings.items()}
    return json.dumps([sorted(map(str, readings.items())), sorted(map(str, frame.places.items()))])
