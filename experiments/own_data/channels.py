"""Which topic or file each stream of the settings is, and how its values are taken from the messages."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from experiments.own_data.facts import Facts
from experiments.own_data.kinds import COLUMNS, ENDS, MESSAGES, STREAM_KINDS, fields_of, is_enough
from experiments.own_data.settings import Settings
from experiments.own_data.stream import Stream
from experiments.own_data.units import Door
from experiments.recorded.inputs import Input, LeftOut, Taker, Topic
from experiments.recorded.words import nearest
from filter import InvalidInput

HEADER, RECEIVED = "header", "received"
VARIANCES = {variance for kind in STREAM_KINDS.values() for several in kind.variances.values() for variance in several}


@dataclass(frozen=True, eq=False)
class Channel:
    """A stream's topic, and what is taken from its messages.

    Attributes:
        stream: What the settings say.
        topic: Where it is.
        rank: Of the stream in the settings, from 0 on.
        body: The field of a record that names who is measured, if that is known of the whole topic.
        fields: How to take each field.
        stamp: How to take the stamp; None for the time of receipt.
        only: How to take what has to hold a text, and the text.
    """

    stream: Stream
    topic: Topic
    rank: int
    body: Mapping[str, str] | None
    fields: Mapping[str, Taker]
    stamp: Taker | None
    only: Sequence[tuple[Taker, str]]


def channels(settings: Settings, data: Input, left_out: LeftOut) -> list[Channel]:
    """Return what is to be read; topics whose name tells somebody unknown are left out.

    Raises:
        InvalidInput: A stream's topic is not there, or has not what is to be read from it.
    """
    found, open_ = list[Channel](), dict[str, Stream]()
    for rank, stream in enumerate(settings.streams):
        matches = _matches(stream, settings.facts, data, left_out)
        if matches is None:
            open_.setdefault(stream.place, stream)
        for topic, body in matches or ():
            found.append(_channel(stream, topic, data, settings.facts, rank=rank, body=body))
    places = {channel.stream.place for channel in found}
    for place, stream in open_.items():
        if place not in places:
            raise _absent(stream, data)
    return found


def _matches(
    stream: Stream, facts: Facts, data: Input, left_out: LeftOut
) -> list[tuple[Topic, Mapping[str, str] | None]] | None:
    """Return a stream's topics, and who is measured in each, as far as its name says; None if no name fits a {target}."""
    if stream.key != data.key:
        what = "a bag" if data.key == "topic" else "CSV files"
        raise InvalidInput(f'{stream.place}: "{data.key}", as the input is {what}', f'"{stream.key}"')
    if "{target}" in stream.source and "id" not in STREAM_KINDS[stream.kind].fields:
        raise InvalidInput(
            f"{stream.place}: a {stream.key} without {{target}}, as a {stream.kind} is of nobody else", stream.source
        )
    pattern = _pattern(stream, facts)
    fitting = [(topic, match) for topic in data.topics if (match := pattern.fullmatch(topic.name))]
    if "{target}" not in stream.source:
        if len(fitting) != 1:
            raise _absent(stream, data) if not fitting else _several(stream, [topic.name for topic, _ in fitting])
        return [(fitting[0][0], facts.body(stream.target, stream.ids) if stream.target else None)]
    found = list[tuple[Topic, Mapping[str, str] | None]]()
    for topic, match in fitting:
        body = facts.body(match["target"], stream.ids)
        if body is None:
            left_out.add(topic.name, nobody(match["target"]), topic.size)
        elif body == {"target": stream.robot}:
            left_out.add(topic.name, "its name says that the robot measures itself", topic.size)
        else:
            found.append((topic, body))
    return found or None


def nobody(called: str) -> str:
    """Return why what was measured of somebody unknown is left out."""
    return f'no robot or landmark is called "{called}"; in the settings, [team] ids = {{ {called} = NAME }} makes it one'


def _pattern(stream: Stream, facts: Facts) -> re.Pattern[str]:
    called = [each for each, name in {**facts.ids, **stream.ids}.items() if name == stream.robot]
    names = "|".join(map(re.escape, [stream.robot, *called]))
    escaped = re.escape(stream.source).replace(r"\{robot\}", f"(?:{names})")
    return re.compile(escaped.replace(r"\{target\}", "(?P<target>[^/]+)", 1))


def _absent(stream: Stream, data: Input) -> InvalidInput:
    source = stream.source.replace("{robot}", stream.robot)
    expected = f"{stream.place}: a {stream.key} that is there: {nearest(source, [topic.name for topic in data.topics])}"
    return InvalidInput(expected, f'"{source}"')


def _several(stream: Stream, names: Sequence[str]) -> InvalidInput:
    return InvalidInput(f"{stream.place}: one {stream.key} of {stream.robot}", " and ".join(names))


def _channel(stream: Stream, topic: Topic, data: Input, facts: Facts, *, rank: int, body: Mapping[str, str] | None) -> Channel:
    if topic.missing:
        raise InvalidInput(f"{stream.place}: a {stream.key} that can be read", f"{topic.name}, {topic.type}: {topic.missing}")
    _check_body(stream, body, facts)
    fields = _fields(stream, topic, body)
    _check_fields(stream, topic, fields, facts)
    takers = {name: _taker(data, topic, name, path) for name, path in fields.items()}
    only = [(data.taker(topic, path), text) for path, text in stream.only.items()]
    return Channel(stream, topic, rank, body, takers, _stamp(stream, topic, data), only)


def _check_body(stream: Stream, body: Mapping[str, str] | None, facts: Facts) -> None:
    for name in stream.ids.values():
        if name not in (known := [*facts.robots, *facts.landmarks]):
            raise InvalidInput(f"{stream.place}: ids: names of robots and landmarks: {nearest(name, known)}", f'"{name}"')
    if stream.target and body is None:
        raise InvalidInput(f"{stream.place}: target: the name of a robot or landmark", f'"{stream.target}"')
    if body == {"target": stream.robot}:
        raise InvalidInput(f"{stream.place}: target: another one than the robot itself", f'"{stream.robot}"')
    ways = [f'"{way}"' for way, there in (("target", stream.target), ("id", "id" in stream.fields)) if there]
    ways += ["{target}"] if "{target}" in stream.source else []
    if len(ways) > 1:
        raise InvalidInput(f"{stream.place}: who is measured, said once", " and ".join(ways))


def _fields(stream: Stream, topic: Topic, body: Mapping[str, str] | None) -> dict[str, str]:
    kind = stream.kind
    if topic.fields:
        known = {name: name for name in COLUMNS[kind]}
        if "id" in STREAM_KINDS[kind].fields and body is None:
            known["id"] = "id"
        if kind == "range_difference" and not stream.landmarks:
            known |= {name: name for name in ENDS}
    else:
        known = MESSAGES[kind].get(topic.type, {})
    fields = fields_of(kind, known, stream.fields)
    if stream.k_sigma:
        return fields
    if unused := sorted(VARIANCES & set(stream.fields)):
        raise InvalidInput(f'{stream.place}: "k_sigma" to go with "{unused[0]}": how many deviations are a bound', "none")
    return {name: path for name, path in fields.items() if name not in VARIANCES}


def _check_fields(stream: Stream, topic: Topic, fields: Mapping[str, str], facts: Facts) -> None:
    kind = STREAM_KINDS[stream.kind]
    if not is_enough(stream.kind, fields):
        usual = ", ".join(MESSAGES[stream.kind]) or "none"
        needs = " or ".join(" and ".join(needs) for needs in kind.needs)
        expected = f"{stream.place}: where in its messages {needs} are, by paths (without paths are understood: {usual})"
        raise InvalidInput(expected, f"{topic.name}, {topic.type}, and paths of {', '.join(fields) or 'nothing'}")
    if "id" in kind.fields and "id" not in fields and not stream.target and "{target}" not in stream.source:
        raise InvalidInput(f'{stream.place}: who is measured: "target", "id" or {{target}} in the {stream.key}', "none of them")
    if "id" not in kind.fields and (starred := [path for path in fields.values() if "[*]" in path]):
        raise InvalidInput(f"{stream.place}: one value in each message", f'"{starred[0]}"')
    if stream.k_sigma and not {name for several in kind.variances.values() for name in several} <= set(fields):
        raise InvalidInput(f"{stream.place}: a bound, as {topic.type} has no covariance for k_sigma", "k_sigma")
    if stream.kind == "odometry" and "turn" not in fields:
        _check_turning(stream, facts)
    if "latitude" in fields:
        _check_latitude(stream, facts)
    if stream.kind == "range_difference":
        _check_difference(stream, fields, facts)


def _check_difference(stream: Stream, fields: Mapping[str, str], facts: Facts) -> None:
    """Refuse a difference between what are no two landmarks whose places are known, or in an arena without end."""
    told = [name for name in ENDS if name in fields]
    if bool(stream.landmarks) == bool(told) or len(told) == 1:
        expected = f'{stream.place}: the two landmarks, said once: landmarks = [first, second], or "first" and "second"'
        raise InvalidInput(expected, " and ".join(["landmarks"] * bool(stream.landmarks) + told) or "neither")
    for name in stream.landmarks:
        if "landmark" not in (facts.body(name, stream.ids) or {}):
            expected = f"{stream.place}: landmarks: names whose places are known: {nearest(name, list(facts.landmarks))}"
            raise InvalidInput(expected, f'"{name}"')
    if any(map(math.isinf, (*facts.arena[0], *facts.arena[1]))):
        raise InvalidInput(f"{stream.place}: an arena without open ends, in which a range difference is read", "none")


def _check_turning(stream: Stream, facts: Facts) -> None:
    """Refuse poses so far apart that nobody knows to which side a robot turned: its way would be that of the other side."""
    turn = stream.longest * facts.turn_rate_limit[stream.robot]
    if turn >= math.pi:
        expected = f"{stream.place}: longest: a time in which a robot turns by less than half a circle, at its turn_rate_limit"
        raise InvalidInput(expected, f"{stream.longest:g} s, {turn:.3g} rad")


def _check_latitude(stream: Stream, facts: Facts) -> None:
    if facts.origin is None:
        raise InvalidInput(f"{stream.place}: [team] origin = [latitude, longitude] of x = y = 0, in degrees", "none")
    if stream.door != Door():
        raise InvalidInput(f"{stream.place}: neither unit nor convention, as latitudes are in degrees, bounds in metres", "one")


def _taker(data: Input, topic: Topic, name: str, path: str) -> Taker:
    if name != "orientation":
        return data.taker(topic, path)
    parts = path.split()
    parts = parts if len(parts) == 4 else [f"{path}.{axis}" for axis in "xyzw"]
    takers = [data.taker(topic, part) for part in parts]
    return lambda content: [taker(content) for taker in takers]


def _stamp(stream: Stream, topic: Topic, data: Input) -> Taker | None:
    stamp, unit, place = stream.clock.stamp, stream.clock.unit, stream.place
    if data.key == "file":
        if not stamp or not unit:
            raise InvalidInput(f'{place}: "stamp", a column, and "stamp_unit", here or in [input]', f'"{stamp}" and "{unit}"')
        return data.taker(topic, stamp)
    if not stamp:
        raise InvalidInput(f'{place}: stamp = "header", or "received", here or in [input]', "none")
    if stamp in (HEADER, RECEIVED) and unit:
        raise InvalidInput(f'{place}: no "stamp_unit" where stamp = "{stamp}"', f'"{unit}"')
    if stamp == RECEIVED:
        return None
    if stamp == HEADER and not data.has_field(topic, "header.stamp"):
        raise InvalidInput(f'{place}: stamp = "received", as {topic.type} has no header', '"header"')
    return data.taker(topic, "header.stamp" if stamp == HEADER else stamp)
