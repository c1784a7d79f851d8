"""Frames in which somebody lies: what one suspect says is something else."""

from dataclasses import replace

import numpy as np

from filter import Bearing, Compass, Range, Suspect, wrap
from filter.diagnosis.told import said_by


def lied(frame, suspect, rng, *, long=False, size=None):
    """Return a frame in which all that a suspect says of it is off; ranges alone, and too long, if lies are long."""
    return replace(frame, measurements=tuple(_wrong(suspect, record, rng, long, size) for record in frame.measurements))


def _wrong(suspect, record, rng, long, size):
    lies, off = said_by(suspect, record), rng.choice([0.02, 0.3, 3.0, 20.0]) if size is None else size
    if isinstance(record, Range):
        sign = 1.0 if long else rng.choice([-1.0, 1.0])
        return replace(record, range=np.where(lies, np.maximum(0, record.range + sign * off), record.range))
    if long:
        return record
    if isinstance(record, Bearing):
        return replace(record, bearing=wrap(np.where(lies, record.bearing + rng.normal() * off, record.bearing)))
    if isinstance(record, Compass):
        return replace(record, heading=wrap(np.where(lies, record.heading + rng.normal() * off, record.heading)))
    return record


def one_liar_a_window(frames, suspects, window, rng, *, long=False):
    """Return frames in which one suspect lies, now and then, for a while, and another one no sooner than a window later."""
    found, liar, since = [], None, -np.inf
    for frame in frames:
        if liar is None or frame.time - since > window:
            liar, until = suspects[int(rng.integers(len(suspects)))], frame.time + rng.uniform(0, 2 * window)
        if frame.time <= until and rng.random() < 0.7:
            frame, since = lied(frame, liar, rng, long=long), frame.time  # noqa: PLW2901
        found.append(frame)
    return found


def pairs_that_lie(frames, robots, bodies, window, rng):
    """Return frames of which one in any window has lies: several, but of each robot one says or is said of at most."""
    found, since = [], -np.inf
    for frame in frames:
        if frame.time - since > window and rng.random() < 0.6:
            since, order = frame.time, rng.permutation(bodies).tolist()
            for one, other in zip(order[::2], order[1::2], strict=False):
                if one < robots:
                    frame = lied(frame, Suspect("sighting", one, other), rng)  # noqa: PLW2901
        found.append(frame)
    return found
