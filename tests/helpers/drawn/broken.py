"""Episodes in which one bound is broken, followed by a filter that goes on."""

import numpy as np

from experiments.broken.episodes import Episode
from experiments.broken.fault import KINDS
from filter import SetMembershipFilter


def drawn(kind, seed, landmarks=4):
    """Return an episode of a kind; None for one in which every bound holds."""
    return Episode.drawn(np.random.default_rng([seed, KINDS.index(kind) if kind else 99]), kind, landmarks)


def going_on(team, **options):
    return SetMembershipFilter(team, policy="reject", **options)


def stepped(filter_, belief, frame):
    """Return the belief after a frame."""
    if frame.time != belief.time or frame.odometry is not None:
        belief = filter_.predict(belief, frame.time, frame.odometry)
    return filter_.update(belief, frame.measurements)


def followed(episode, filter_=None, count=None):
    """Return the beliefs after each frame."""
    filter_ = filter_ or going_on(episode.team)
    belief, found = filter_.start(0.0, episode.positions, episode.headings), []
    for frame in episode.frames[:count]:
        belief = stepped(filter_, belief, frame)
        found.append(belief)
    return found


def outside(belief, truth):
    """Return (n,) whether the truth is outside though the guarantee is in force."""
    inside = belief.regions.contains(truth.positions) & belief.headings.contains(truth.headings)
    return ~inside & belief.guarantee.in_force


def culprit(fault):
    """Return who is guilty of a fault, as `Suspect.who` says it."""
    kind, bodies = fault.guilty
    robot, target = (-1, *bodies) if kind == "body" else (*bodies, -1)[:2]
    return kind, robot, target
