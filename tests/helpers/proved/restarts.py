"""A team of which two robots lie at a time, so that they start over."""

from dataclasses import replace

import numpy as np
from helpers.worlds import World

from experiments.logs import Header, InitialSet
from filter import Bearing, Frame, Truth

# By the numbers of frames, who lies about which landmark. One robot lies, and while that is in doubt another one: both start
# over. Then the third one lies, twice, and is found out while they are waiting.
IN_DOUBT = {1: [(0, 3)], 2: [(1, 4)], 4: [(2, 3)], 5: [(2, 4)]}
AT_ONCE = {1: [(0, 3), (1, 4)], 2: [(1, 3)]}  # two robots lie at once, and all start over; and again, as one lies again
OFF = 0.8  # by so much is a bearing wrong [rad]


def lying_team(lies, count):
    """Return the header, the initial sets, and so many frames."""
    world = World(np.random.default_rng(0), robots=3, landmarks=2, sight=20.0)
    world.team = replace(world.team, arena=np.outer((-4.0, 10.0), [1, 1]))
    arcs = world.initial_headings(0.2)
    heads = zip(arcs.centre.tolist(), arcs.bound.tolist(), strict=True)
    initial = [InitialSet(one.vertices, head) for one, head in zip(world.initial_sets(), heads, strict=True)]
    return Header(world.team, 0.0, 10.0), initial, [_frame(world, lies.get(k, ()), k > 0) for k in range(count)]


def _frame(world, lies, has_moved):
    motion = world.move() if has_moved else None
    records = tuple(_lying(record, lies) for record in world.measure())
    return Frame(world.time, motion, records, Truth(world.positions, world.headings))


def _lying(record, lies):
    if not isinstance(record, Bearing):
        return record
    off = sum((np.where((record.robot == robot) & (record.target == target), OFF, 0) for robot, target in lies), np.zeros(1))
    return Bearing(record.time, record.robot, record.target, record.bearing + off, record.bound)
