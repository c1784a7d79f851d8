"""Records at stamps of their own become frames: one for each time at which something was measured, or is asked for."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush

import numpy as np

from filter.arrays import instance, number, one_by_one
from filter.errors import OutOfOrder
from filter.motions import Motions
from filter.records.frame import Frame, Truth
from filter.records.measurements import MEASUREMENTS, Measurement
from filter.records.odometry import Odometry, Twist
from filter.records.presence import Change, Left, Placed
from filter.records.record import called
from filter.team import Team

Arrival = Measurement | Odometry | Twist | Placed | Left | Frame
ARRIVALS = (*MEASUREMENTS, Odometry, Twist, Placed, Left, Frame)


def frames_of(team: Team, start: float, arrivals: Iterable[Arrival], hold: float = 1.0) -> Iterator[Frame]:
    """Yield a frame for each time at which something was measured, and for each that came, with the motion since the last one.

    A frame is held back until something has come that is newer by more than `hold`; motion that is not known by then is filled
    up by the limits. So records may come late by as much, in any order. See `Motions`.

    Args:
        team: Whose records these are.
        start: When what is known before begins [s].
        arrivals: Measurements, odometry, twists, robots that are placed or leave, and frames that are asked for, as they
            come; frames may have all of these, truth, and odometry from any time on.
        hold: How late a record may be, from 0 on [s].

    Raises:
        OutOfOrder: A record is older than a frame that is done, or than the start, or ends a twist that such a frame relied on.
        InvalidInput: Something is no such record, or names an unknown robot or landmark, or odometry overlaps.
    """
    instance("team", team, Team)
    begin, patience = number("start [s]", start), number("hold [s]", hold, 0)
    return _Stream(team, begin, patience).frames(one_by_one("records, as they come", arrivals))


@dataclass
class _Asked:
    """What came of one time."""

    measurements: list[Measurement] = field(default_factory=list)
    truth: Truth | None = None
    changes: list[Change] = field(default_factory=list)


class _Stream:
    """What has come and is not done yet."""

    def __init__(self, team: Team, start: float, hold: float) -> None:
        self._team, self._hold = team, hold
        self._motions, self._waiting, self._times = Motions(team), dict[float, _Asked](), list[float]()
        self._done, self._newest, self._first = start, -np.inf, True

    def frames(self, arrivals: Iterator[Arrival]) -> Iterator[Frame]:
        for record in arrivals:
            self._take(record)
            self._newest = max(self._newest, record.time)
            if self._times and self._times[0] < self._newest - self._hold:
                yield from self._ended(self._newest - self._hold)
        yield from self._ended(np.inf)

    def _take(self, record: Arrival) -> None:
        """Take a record in, or the records of a frame."""
        instance("a record, as it comes", record, *ARRIVALS)
        # A twist that holds from the last frame on is in time; one that ended another before that frame is not.
        is_done = record.time < self._done or (record.time == self._done and not isinstance(record, Twist))
        if is_done and not (self._first and (record.time == self._done or isinstance(record, Twist))):
            raise OutOfOrder(called(type(record)), record.time, self._done)
        if isinstance(record, Odometry | Twist):
            self._drive(record)
            return
        if record.time not in self._waiting:
            heappush(self._times, record.time)
        asked = self._waiting.setdefault(record.time, _Asked())
        if isinstance(record, Placed | Left):
            asked.changes.append(self._team.checked_change(record))
            return
        if not isinstance(record, Frame):
            self._team.check(record)
            asked.measurements.append(record)
            return
        if record.odometry is not None:
            self._drive(record.odometry)
        asked.measurements += record.measurements
        asked.changes += record.changes
        if record.truth is not None:
            asked.truth = record.truth if asked.truth is None else _both(asked.truth, record.truth)

    def _drive(self, record: Odometry | Twist) -> None:
        if not self._first and isinstance(record, Odometry) and self._motions.ends_before(record, self._done):
            raise OutOfOrder("odometry", record.start, self._done)
        self._motions = self._motions.merged(record)

    def _ended(self, old: float) -> Iterator[Frame]:
        """Yield the frames that are older than what may be late."""
        while self._times and self._times[0] < old:
            time = heappop(self._times)
            asked, odometry = self._waiting.pop(time), self._motions.between(self._done, time)
            self._done, self._first = time, False
            self._motions = self._motions.since(time)
            yield Frame(time, odometry, asked.measurements, asked.truth, asked.changes)


def _both(known: Truth, more: Truth) -> Truth:
    """Return the truth that two tell of; the second counts where both do."""
    places = np.where(np.isnan(more.positions), known.positions, more.positions)
    return Truth(places, np.where(np.isnan(more.headings), known.headings, more.headings))
