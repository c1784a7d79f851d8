"""From a recording to a log: every stream's messages become records, and records come out in the order of their stamps."""

from __future__ import annotations

import heapq
import json
import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import IO, NamedTuple

from experiments.own_data.channels import Channel, channels
from experiments.own_data.differences import DifferenceReading
from experiments.own_data.driven import OdometryReading, TwistReading
from experiments.own_data.mountings import TRANSFORMS, mountings
from experiments.own_data.reading import Reading, Record, Unmeasured, placed
from experiments.own_data.readings import CompassReading, PositionReading, Sightings, TruthReading
from experiments.own_data.settings import Settings
from experiments.own_data.units import SECOND, nanoseconds, seconds
from experiments.recorded import Input, LeftOut, Message
from filter import InvalidInput

READINGS: dict[str, type[Reading]] = {
    "odometry": OdometryReading,
    "twist": TwistReading,
    "compass": CompassReading,
    "range": Sightings,
    "bearing": Sightings,
    "detections": Sightings,
    "range_difference": DifferenceReading,
    "position": PositionReading,
    "truth": TruthReading,
}
NOW_AND_THEN = 100_000  # messages
EPOCH = 10**9 * SECOND  # a clock that shows the date is beyond it [ns]


class Entry(NamedTuple):
    """A record on its way into the log; entries are in the order of their stamps, then of the settings, then of arrival.

    Attributes:
        stamp: When [ns].
        rank: Of its stream.
        number: Of its arrival.
        place: Where it comes from.
        topic: The topic's or file's name.
        record: What is written.
    """

    stamp: int
    rank: int
    number: int
    place: str
    topic: str
    record: Record


@dataclass(frozen=True, eq=False)
class Converted:
    """What came of a conversion.

    Attributes:
        records: How many there are of each kind.
        start: Time of the initial sets [s].
        end: Time of the last record [s].
        left_out: One line for each topic and reason.
    """

    records: Mapping[str, int]
    start: float
    end: float
    left_out: Sequence[str]


def convert(settings: Settings, data: Input, path: Path, told: Callable[[int], None] = lambda _: None) -> Converted:
    """Write a log; it is there as a whole in the end, or not at all.

    Args:
        settings: What to read, and how.
        data: Where to read it.
        path: Where to write it.
        told: Is given the number of messages read so far, now and then.

    Raises:
        InvalidInput: The settings do not fit the recording, or it is damaged.
        OSError: The log cannot be written.
    """
    left_out = LeftOut()
    found = channels(settings, data, left_out)
    _leave_out(data, {channel.topic.name for channel in found}, left_out)
    readings = [READINGS[channel.stream.kind](channel, settings.facts, left_out) for channel in found]
    entries = ordered(_entries(data, readings, told), settings.lateness)
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        with temporary.open("w", encoding="utf-8", newline="\n") as file:
            counts, start, end = _write(file, entries, settings, left_out)
            file.flush()
            os.fsync(file.fileno())
        if counts:
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return Converted(counts, start, end, left_out.lines(data.topics))


def ordered(entries: Iterable[Entry], lateness: float) -> Iterator[Entry]:
    """Yield entries in their order, though they arrive up to `lateness` [s] after newer ones; so much of them is in memory.

    Raises:
        InvalidInput: One comes later than that.
    """
    waiting, late, newest = list[Entry](), round(lateness * SECOND), None
    for entry in entries:
        newest = entry if newest is None or entry.stamp > newest.stamp else newest
        if entry.stamp < newest.stamp - late:
            raise _too_late(entry, newest, lateness)
        heapq.heappush(waiting, entry)
        while waiting[0].stamp < newest.stamp - late:
            yield heapq.heappop(waiting)
    while waiting:
        yield heapq.heappop(waiting)


def _too_late(entry: Entry, newest: Entry, lateness: float) -> InvalidInput:
    behind = seconds(newest.stamp - entry.stamp)
    remedy = "[input] lateness = SECONDS if that is so; else clock_offset or stamp of the stream whose clock differs"
    came = f"{seconds(entry.stamp)!r} s, {behind:.6g} s before the newest one ({newest.place})"
    return InvalidInput(f"{entry.place}: a stamp at most {lateness:g} s older than one that came before; {remedy}", came)


def _entries(data: Input, readings: Sequence[Reading], told: Callable[[int], None]) -> Iterator[Entry]:
    """Return the records as they arrive; several files are gone through side by side, by their stamps."""
    by_topic = defaultdict[str, list[Reading]](list)
    for reading in readings:
        by_topic[reading.channel.topic.name].append(reading)
    numbers = count(1)
    flows = (_of_flow(_counted(flow, numbers, told), by_topic) for flow in data.flows(by_topic))
    arrived = heapq.merge(*flows, key=lambda entry: entry.stamp)
    return (entry._replace(number=number) for number, entry in enumerate(arrived))


def _counted(messages: Iterator[Message], numbers: Iterator[int], told: Callable[[int], None]) -> Iterator[Message]:
    for message, number in zip(messages, numbers, strict=False):
        if number % NOW_AND_THEN == 0:
            told(number)
        yield message


def _of_flow(messages: Iterator[Message], readings: Mapping[str, Sequence[Reading]]) -> Iterator[Entry]:
    for message in messages:
        for reading in readings[message.topic]:
            try:
                stamp = stamp_of(message, reading.channel)
                if stamp is None:
                    continue
                for record in reading.records(message, stamp):
                    yield Entry(stamp, reading.channel.rank, 0, message.place, message.topic, record)
            except Unmeasured as why:
                reading.skip(why)


def stamp_of(message: Message, channel: Channel) -> int | None:
    """Return a message's time by the team's clock [ns], or None if it is not among those that the stream is made of.

    Raises:
        InvalidInput: The stamp is none, or was never filled in.
    """
    if any(str(take(message.content)).strip() != text for take, text in channel.only):
        return None
    clock = channel.stream.clock
    if channel.stamp is None:
        stamp = message.received or 0
    else:
        with placed(message.place):
            stamp = nanoseconds(channel.stamp(message.content), clock.unit)
        if stamp == 0 and (message.received or 0) > EPOCH:
            expected = f'{message.place}: a stamp that was filled in; else say stamp = "received" in {channel.stream.place}'
            raise InvalidInput(expected, "0")
    return stamp + round(clock.offset * SECOND)


def _leave_out(data: Input, used: set[str], left_out: LeftOut) -> None:
    """Count the topics that are not read at all."""
    for topic in data.topics:
        if topic.name in used:
            if not topic.size:
                left_out.add(topic.name, "it is empty", 0)
        elif topic.size == 0 or left_out.has(topic.name):
            continue
        elif topic.type in TRANSFORMS and not topic.missing:
            left_out.add(topic.name, mountings(data, topic), topic.size)
        else:
            left_out.add(topic.name, topic.missing or "the settings do not name it", topic.size)


def _write(file: IO[str], entries: Iterator[Entry], settings: Settings, left_out: LeftOut) -> tuple[Counter[str], float, float]:
    """Write the records; return how many there are of each kind, and the times of the first and the last."""
    facts, counts, head = settings.facts, Counter[str](), _head(entries, _reach(settings))
    start = end = min((begin(entry.record) for entry in head), default=0.0) if facts.start is None else facts.start
    for record in (facts.header(start), *facts.initial()):
        _write_record(file, record)
    for entry in chain(head, entries):
        if begin(entry.record) < start:
            left_out.add(entry.topic, "it is before the start", 1, "records")
            continue
        _write_record(file, entry.record)
        counts[entry.record["record"]] += 1
        end = entry.record["time"]
    return counts, start, end


def _reach(settings: Settings) -> int:
    """Return how long before its stamp a record may begin [ns]."""
    return max((round(stream.longest * SECOND) for stream in settings.streams if stream.kind == "odometry"), default=0)


def _head(entries: Iterator[Entry], reach: int) -> list[Entry]:
    """Return the first entries: all those that may begin before the first one's stamp, as motion does [ns]."""
    head = list[Entry]()
    for entry in entries:
        head.append(entry)
        if entry.stamp > head[0].stamp + reach:
            break
    return head


def begin(record: Record) -> float:
    """Return when a record begins to say something [s]."""
    return float(record["start"] if "start" in record else record["time"])


def _write_record(file: IO[str], record: Record) -> None:
    file.write(json.dumps(record, allow_nan=False) + "\n")
