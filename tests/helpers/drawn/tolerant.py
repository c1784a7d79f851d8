"""Filters that tolerate lies, and what is compared of them."""

from dataclasses import replace

from helpers.drawn.broken import stepped
from helpers.teams import snapshot

from filter import SetMembershipFilter, Tolerance

WINDOW = 4.0  # [s]


def tolerant(team, suspects="pairs", lies="any", window=WINDOW, q=1, **options):
    return SetMembershipFilter(team, tolerance=Tolerance(q, window, suspects, lies), **options)


def light(team, suspects="pairs", window=WINDOW):
    """Return a filter that takes less time."""
    return SetMembershipFilter.light(team, tolerance=Tolerance(1, window, suspects))


def known(belief):
    """Return what a belief says, to be compared bit by bit."""
    return snapshot(replace(belief, alternatives=None, diagnosis=None, events=(), guarantee=None))


def suspects_in(frames, suspects="pairs", lies="any"):
    return Tolerance(1, 1.0, suspects, lies).heard([frame.measurements for frame in frames], 0.0)


def followed_in(scene, filter_):
    belief = filter_.start(0.0, scene.initial, scene.headings)
    for frame in scene.frames:
        belief = stepped(filter_, belief, frame)
    return belief


def at(time, frame):
    """Return what is measured at a frame, as of another time."""
    return tuple(replace(each, time=time) for each in frame.measurements)
