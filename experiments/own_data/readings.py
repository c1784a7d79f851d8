"""From a message to records of what was measured: compass, ranges and bearings, positions; and of the truth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from experiments.own_data.channels import Channel, nobody
from experiments.own_data.facts import Facts
from experiments.own_data.reading import Reading, Record, Unmeasured, number, placed
from experiments.own_data.table import Bound
from experiments.own_data.units import local_plane, metres, radians
from experiments.recorded import LeftOut, Message
from filter import InvalidInput, seen_position


class CompassReading(Reading):
    """Headings."""

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one record, see `Reading`."""
        bound = self.stream.bounds.get("bound")
        if bound is None:
            variance = self.channel.fields["variance"](message.content)
            bound = min(radians(self.deviations("bound", variance, message.place), self.door.angle), math.pi)
        yield self.head("compass", stamp) | {"heading": self.heading(message), "bound": bound} | self.stream.sensors


class Sightings(Reading):
    """Ranges, bearings, or both, and headings, of one target or of several in each message."""

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one or two records for each target, see `Reading`."""
        values = {name: take(message.content) for name, take in self.channel.fields.items()}
        lists = {name: value for name, value in values.items() if isinstance(value, list)}
        if not lists:
            yield from self._of_one(values, message, stamp)
            return
        for each in _together(lists, message.place):
            try:
                yield from self._of_one(values | each, message, stamp)
            except Unmeasured as why:
                self.skip(why, "entries")

    def _of_one(self, entry: Mapping[str, Any], message: Message, stamp: int) -> list[Record]:
        body, found, mounted = self._body(entry), list[Record](), dict(self.stream.sensors)
        if not self.facts.carries_tags(body):
            mounted.pop("target_sensor", None)
        body |= mounted
        if "bearing" in entry:
            found.append(self.head("bearing", stamp) | body | self._bearing(entry, message.place))
        if "range" in entry:
            found.append(self.head("range", stamp) | body | self._range(entry, message.place))
        if "x" in entry:
            found += [self.head(kind, stamp) | body | seen for kind, seen in self._position(entry, message.place).items()]
        if "heading" in entry:
            found += [self.head("relative_heading", stamp) | body | seen for seen in self._heading(entry, body, message.place)]
        return found

    def _body(self, entry: Mapping[str, Any]) -> Record:
        if self.channel.body is not None:
            return dict(self.channel.body)
        called = str(entry["id"]).strip()
        body = self.facts.body(called, self.stream.ids)
        if body is None:
            raise Unmeasured(nobody(called))
        if body == {"target": self.stream.robot}:
            raise Unmeasured("it names the robot itself as who was measured")
        return dict(body)

    def _bearing(self, entry: Mapping[str, Any], place: str) -> Record:
        with placed(place):
            bearing = self.door.bearing(number(entry["bearing"], "bearing", place))
        return {"bearing": bearing, "bound": self._bound_of("bearing", entry, place)}

    def _range(self, entry: Mapping[str, Any], place: str) -> Record:
        value = number(entry["range"], "range", place)
        if value < 0:
            raise Unmeasured("its range is below 0")
        if "greatest" in entry and not _is_within(value, entry["least"], entry["greatest"]):
            raise Unmeasured("its range is not from min_range to max_range, which says: discard it")
        relative = "relative_bound" if self.stream.kind == "range" else "range_relative_bound"
        bounds = {"bound": self._bound_of("range", entry, place), "relative_bound": self.stream.bounds[relative]}
        return {"range": self.door.distance(value)} | bounds

    def _position(self, entry: Mapping[str, Any], place: str) -> dict[str, Record]:
        """Return a bearing and a range of where the sensor sees somebody."""
        ahead, left = (number(entry[name], name, place) for name in ("x", "y"))
        with placed(place):
            position = self.door.distance(ahead), self.door.aside(left)
            bearing, reach = seen_position(0.0, 0, 1, position, self.bound("position_bound"))
        return {
            "bearing": {"bearing": bearing.bearing.item(), "bound": bearing.bound.item()},
            "range": {"range": reach.range.item(), "bound": reach.bound.item(), "relative_bound": 0.0},
        }

    def _heading(self, entry: Mapping[str, Any], body: Mapping[str, str], place: str) -> list[Record]:
        """Return what is seen of a mate's heading, if it is: the rest of an entry counts without it."""
        try:
            if "target" not in body:
                raise Unmeasured("of landmarks a heading says nothing")
            seen = number(entry["heading"], "heading", place)
        except Unmeasured as why:
            self.skip(why, "headings")
            return []
        with placed(place):
            return [{"heading": self.door.bearing(seen), "bound": self.stream.bounds["heading_bound"]}]

    def _bound_of(self, what: str, entry: Mapping[str, Any], place: str) -> Bound:
        name = f"{what}_bound" if self.stream.kind == "detections" else "bound"
        if name in self.stream.bounds:
            return self.stream.bounds[name]
        deviations = self.deviations(name, entry["variance"], place)
        if what == "range":
            return metres(deviations, self.door.length)
        bound = radians(deviations, self.door.angle)
        if bound >= math.pi:
            raise Unmeasured("its covariance allows any direction")
        return bound


def _together(lists: Mapping[str, list[Any]], place: str) -> Iterator[dict[str, Any]]:
    if len({len(values) for values in lists.values()}) > 1:
        lengths = ", ".join(f"{len(values)} of {name}" for name, values in lists.items())
        raise InvalidInput(f"{place}: as many of each", lengths)
    for each in zip(*lists.values(), strict=True):
        yield dict(zip(lists, each, strict=True))


def _is_within(value: float, least: float, greatest: float) -> bool:
    """Return whether a range is one that its sensor can measure; a greatest one of 0 was never filled in."""
    return greatest == 0 or least <= value <= greatest


class PositionReading(Reading):
    """Positions in the plane, or latitudes and longitudes."""

    def __init__(self, channel: Channel, facts: Facts, left_out: LeftOut) -> None:
        super().__init__(channel, facts, left_out)
        self._plane = local_plane(*facts.origin) if facts.origin and "latitude" in channel.fields else None

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one record, see `Reading`."""
        if "status" in self.channel.fields and self.value(message, "status") < 0:
            raise Unmeasured("its status says that there is no fix")
        position = list(self._place(message))
        yield self.head("position", stamp) | {"position": position} | self._bounds(message) | self.stream.sensors

    def _place(self, message: Message) -> tuple[float, float]:
        if self._plane is not None:
            return self._plane(self.value(message, "latitude"), self.value(message, "longitude"))
        return self.door.place(self.value(message, "x"), self.value(message, "y"))

    def _bounds(self, message: Message) -> Record:
        bound = self.stream.bounds.get("bound")
        if bound is None:
            both = [self.channel.fields[name](message.content) for name in ("variance_x", "variance_y")]
            x, y = (self.deviations("bound", variance, message.place) for variance in both)
            bound = self.door.place(x, y)
        if self.stream.radius:
            return {"radius": bound}
        return {"bound": list(bound) if isinstance(bound, tuple) else bound}


class TruthReading(Reading):
    """Where the robot really was."""

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one record, see `Reading`."""
        position = list(self.door.place(self.value(message, "x"), self.value(message, "y")))
        yield self.head("truth", stamp) | {"position": position, "heading": self._heading(message)}

    def _heading(self, message: Message) -> float | None:
        """Return the heading, or None if nobody knows it: a motion capture without orientation says zeros."""
        if not {"heading", "orientation"} & set(self.channel.fields):
            return None
        try:
            return self.heading(message)
        except Unmeasured:
            return None
