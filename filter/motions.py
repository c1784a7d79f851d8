"""What odometry at stamps of its own says of a team's motion from any time to any other.

Records of a robot follow one another as its sensors have it, not as its filter does. Here they are joined, where several lie
between two times; cut, where one reaches beyond; and filled up by the robot's limits, where none was made.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from filter.arrays import Array, Frozen, checked, instance, number, read_only, settle
from filter.errors import InvalidInput
from filter.joined import COLUMNS, inserted, joined, later, overlap
from filter.records.odometry import Odometry, Twist
from filter.team import Team

ROBOT, START, TIME, DISTANCE, STEADY = 0, 1, 2, 3, 10  # columns of a part, ...
RATES = [3, 4, 5, 6, 8]  # ... and those of a twist that grow with time


def _no_parts() -> Array:
    return np.zeros((0, COLUMNS))


@dataclass(frozen=True, eq=False)
class Motions(Frozen):
    """The motion of a team's robots, as far as odometry and commands have told of it.

    Within a record that has to be cut a robot drives steadily but for its limits: its speed and its turn rate change no faster
    than `Team.acceleration_limit` and `Team.turn_acceleration_limit` allow, and are never above `Team.speed_limit` and
    `Team.turn_rate_limit`, unless the record itself says so. The bounds of its direction and of its slip hold for every part
    of it. A twist may be cut as one likes.

    Attributes:
        team: The robots and their limits.
        parts: (m, COLUMNS) robot, start and end [s], and then the columns of `Odometry` in their order, and whether it may be
            cut as one likes; by robots, and then in order of time.
        twisted: Of which robots a twist has told.
    """

    team: Team = field(metadata=checked(instance, "team", Team))
    parts: Array = field(default_factory=_no_parts)
    twisted: frozenset[int] = frozenset()

    def merged(self, record: Odometry | Twist) -> Motions:
        """Return what is known after one more record, of whatever time; a robot's next one ends its twists before.

        Raises `InvalidInput` if it names an unknown robot, takes no time, or overlaps with other odometry of its robot.
        """
        instance("odometry or a twist", record, Odometry, Twist)
        self.team.check(record)
        new = _parts_of(record)
        if not (new[:, START] < new[:, TIME]).all():
            raise InvalidInput("odometry that takes some time", f"from {record.time!r} s to the same")
        parts = inserted(self.parts, new)
        if overlap(parts):
            parts = _ended(parts)
            self._check_apart(parts)
        twisted = self.twisted.union(record.robot.tolist()) if isinstance(record, Twist) else self.twisted
        return self._with(parts, twisted)

    def _check_apart(self, parts: Array) -> None:
        same = parts[1:, ROBOT] == parts[:-1, ROBOT]
        late = np.flatnonzero(same & (parts[1:, START] < parts[:-1, TIME]))
        if len(late):
            robot, begins, ends = self.team.name(int(parts[late[0], ROBOT])), parts[late[0] + 1, START], parts[late[0], TIME]
            raise InvalidInput(f"odometry of {robot} that begins at {ends.item()!r} s or later", f"{begins.item()!r} s")

    def _with(self, parts: Array, twisted: frozenset[int]) -> Motions:
        motions = object.__new__(Motions)
        settle(motions, team=self.team, parts=read_only(parts), twisted=twisted)
        return motions

    def ends_before(self, record: Odometry | Twist, time: float) -> bool:
        """Return whether a record begins before a time [s], and can end a twist then: what was said of that time may be wrong.

        Of robots that never had a twist there is none to end.
        """
        if isinstance(record, Twist):
            return record.time < time
        return record.start < time and not self.twisted.isdisjoint(record.robot.tolist())

    def since(self, time: float) -> Motions:
        """Return what is known of the time after one [s]."""
        kept = later(self.parts, number("time [s]", time))
        return self if len(kept) == len(self.parts) else self._with(kept, self.twisted)

    def between(self, start: float, time: float) -> Odometry | None:
        """Return how robots moved from one time to another [s]; None where nothing is known of any, or no time passes.

        Robots of which nothing is known in between are not in it. Where one record is just from one time to the other it stays
        as it is. Raises `InvalidInput` if the end is before the start.
        """
        begin, end = number("start [s]", start), number("time [s]", time)
        if end < begin:
            raise InvalidInput(f"a time from the start, {begin!r} s, on", f"{end!r} s")
        if end == begin:
            return None
        found = read_only(joined(self.parts, self.team.limits, np.array([begin, end])))
        if not found.shape[1]:
            return None
        columns = dict(zip(NAMES, found[1:], strict=True))  # views of what nobody can write to
        odometry = object.__new__(Odometry)
        settle(odometry, start=begin, time=end, robot=read_only(found[0].astype(np.int64)), **columns)
        return odometry


NAMES = ("distance", "distance_bound", "turn", "turn_bound", "direction_bound", "slip_bound", "aside")


def _parts_of(record: Odometry | Twist) -> Array:
    """Return the parts of a record, one for each robot."""
    parts = np.empty((len(record.robot), COLUMNS))
    parts[:, ROBOT], parts[:, STEADY] = record.robot, isinstance(record, Twist)
    if isinstance(record, Odometry):
        parts[:, START], parts[:, TIME] = record.start, record.time
        for column, name in enumerate(NAMES, DISTANCE):
            parts[:, column] = getattr(record, name)
        return parts
    parts[:, START], parts[:, TIME] = record.time, record.time + record.hold
    rates = (record.speed, record.speed_bound, record.turn_rate, record.turn_rate_bound)
    lasting = (record.direction_bound, record.slip_rate, record.aside)
    parts[:, DISTANCE:STEADY] = np.stack([*rates, *lasting], axis=1)
    parts[:, RATES] *= (parts[:, TIME] - parts[:, START])[:, None]
    return parts


def _ended(parts: Array) -> Array:
    """Return parts in order with those that may be cut as one likes ended where the next one of the same robot begins."""
    before, after = parts[:-1], parts[1:]
    over = (before[:, STEADY] > 0) & (before[:, ROBOT] == after[:, ROBOT]) & (after[:, START] < before[:, TIME])
    if not over.any():
        return parts
    whole, ends = parts.copy(), np.append(np.where(over, after[:, START], before[:, TIME]), parts[-1:, TIME])
    share = (ends - parts[:, START]) / (parts[:, TIME] - parts[:, START])
    whole[:, RATES] *= share[:, None]
    whole[:, TIME] = ends
    return whole[ends > parts[:, START]]
