"""What a filter was given, in exact numbers: all that a proof starts from. Standard library only.

Read as strictly as the filter's own reader does (docs/log.md): every bound, time and number of a robot is looked at. Frames are
made of the records as there: as long as these come in lock-step a frame ends one, from then on there is one for every stamp
at which something was measured, is known as the truth or is asked for, as soon as something newer by `LATE` has come.
"""

from collections.abc import Iterator
from fractions import Fraction
from heapq import heappop, heappush
from math import inf
from pathlib import Path

from experiments.proof.given.driven import Driven
from experiments.proof.given.frame import Frame
from experiments.proof.given.head import FIRST, Head, fields_of
from experiments.proof.given.records import LATER, MEASURED, parts_of, places_of, readings_of, truth_of
from experiments.proof.given.sensors import CENTRE
from experiments.proof.motion import Piece
from experiments.proof.reading import Broken, Record, located, number, records, shown

LATE = 1.0  # so late a record may be, in a stream [s]


class Log(Head):
    """What the filter was given.

    Attributes:
        frames: All frames, in order.
    """

    def __init__(self, folder: Path) -> None:
        lines = records(folder / "log.jsonl", loose=True)
        super().__init__(lines)
        self.frames = list(_Frames(self).of(self.rest))
        if not self.frames:
            raise Broken("log.jsonl: at least one frame was expected")

    def is_there(self, robot: int) -> bool:
        """Return whether a robot is there at some frame."""
        return any(robot not in frame.away for frame in self.frames)


class _Frames:
    """Makes frames of records.

    `_done` is when the last frame was, or the start; `_begun` whether there was one; `_now` in lock-step when the records were
    that wait for their frame; `_away` who was not there at the last frame.
    """

    def __init__(self, head: Head) -> None:
        self._head, self._driven = head, [Driven(limits) for limits in head.limits]
        self._waiting, self._times = dict[float, Frame](), list[float]()
        self._done, self._begun, self._newest = head.start, False, -inf
        self._in_step, self._away = True, head.away
        self._now: float | None = None

    def of(self, lines: Iterator[tuple[str, Record]]) -> Iterator[Frame]:
        place = "log.jsonl"
        for place, record in lines:
            with located(place):
                kind, time = record["record"], number(record["time"])
                if self._in_step and not self._is_in_step(kind, record, time):
                    self._in_step, self._begun = False, False
                if self._in_step:
                    self._look_at(time)
                self._take(kind, record, time)
            self._newest = max(self._newest, time)
            old = self._newest - LATE if not self._in_step else inf if kind == "frame" else -inf
            yield from self._ended(old)
        if self._in_step and self._now is not None and (self._begun or self._head.version == FIRST):
            raise Broken(f"{place}: the log ends within a frame")
        yield from self._ended(inf)

    def _is_in_step(self, kind: str, record: Record, time: float) -> bool:
        same = self._now in (None, time)
        if kind == "odometry":
            return same and record["start"] == self._done
        return kind != "twist" and (same or self._head.version == FIRST)

    def _look_at(self, time: float) -> None:
        """Raise `Broken` unless a time is the one of the frame that the log is at, in lock-step."""
        if self._now not in (None, time):
            raise Broken(f"t = {time} s in a frame of t = {self._now} s")
        if time < self._done or (time == self._done and self._begun):
            raise Broken(f"t = {time} s does not come after {self._done} s")
        self._now = time

    def _take(self, kind: str, record: Record, time: float) -> None:
        early = time < self._done if kind == "twist" or not self._begun else time <= self._done
        if early and (self._begun or kind != "twist"):  # one that holds at the start may have begun before it
            raise Broken(f"t = {time} s, where the frames up to {self._done} s are done")
        if kind in ("odometry", "twist") and self._is_known(kind):
            for robot, part in parts_of(self._head, kind, record):
                self._driven[robot].add(part)
            return
        if time not in self._waiting:
            heappush(self._times, time)
        self._add(self._waiting.setdefault(time, Frame(time)), kind, record)

    def _is_known(self, kind: str) -> bool:
        return self._head.version > FIRST or kind not in LATER

    def _add(self, frame: Frame, kind: str, record: Record) -> None:
        """Add to a frame what a record says."""
        if kind == "truth":
            told = truth_of(self._head, record)
            if self._in_step and told.keys() & frame.truth.keys():
                raise Broken("one truth of each robot was expected")
            for robot, (spot, way) in told.items():
                before = frame.truth.get(robot, (None, None))
                frame.truth[robot] = before[0] if spot is None else spot, before[1] if way is None else way
        elif kind in MEASURED and self._is_known(kind):
            for who, reading in readings_of(self._head, kind, record):
                frame.readings.setdefault(who, []).append(reading)
                frame.measurements += 1
        elif kind == "position" and self._is_known(kind):
            found = list(places_of(self._head, record))
            for robot, sensor, place in found:
                mount = CENTRE if sensor < 0 else self._head.mounts.of(sensor)
                frame.places.setdefault(robot, []).append((place, mount))
            frame.measurements += len({(robot, sensor) for robot, sensor, _ in found})
        elif kind == "initial" and self._is_known(kind):
            frame.changes.append(self._head.placed(record, "time"))
        elif kind == "leave" and self._is_known(kind):
            frame.changes.append((self._head.robot(fields_of(record, kind, {"time", "robot"})["robot"]), None))
        elif kind != "frame" or set(record) != {"record", "time"}:
            raise Broken(f"a record {shown(kind)} that there is not, or not with {shown(sorted(record))}")

    def _ended(self, old: float) -> Iterator[Frame]:
        """Yield the frames that are older, each with the motion since the one before."""
        while self._times and self._times[0] < old:
            frame = self._waiting.pop(heappop(self._times))
            frame.pieces = [self._pieces(robot, frame.time) for robot in range(self._head.robots)]
            for driven in self._driven:
                driven.forget(frame.time)
            self._done, self._begun, self._now = frame.time, True, None
            self._let_go(frame)
            yield frame

    def _pieces(self, robot: int, time: float) -> list[Piece]:
        """Return how a robot has moved since the last frame; odometry of one that was away says nothing."""
        if robot not in self._away:
            return self._driven[robot].pieces(self._done, time)
        spent = Fraction(time) - Fraction(self._done)
        return [self._head.limits[robot].unknown(spent)] if spent else []

    def _let_go(self, frame: Frame) -> None:
        """Note who comes and who leaves; raise `Broken` if something was measured by a robot that is away, or of it."""
        for robot, start in frame.changes:
            self._away = self._away - {robot} if start else self._away | {robot}
        frame.away = self._away
        named = {body for _, *two in frame.readings for body in two} | frame.places.keys()
        if gone := self._away & named:
            raise Broken(f"log.jsonl: something is measured at t = {frame.time} s by or of robot {min(gone)}, which is away")
