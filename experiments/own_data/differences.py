"""From differences of ranges (TDOA) to positions: half-planes around a branch of a hyperbola, as far as the arena reaches."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from experiments.own_data.channels import Channel, nobody
from experiments.own_data.facts import Facts
from experiments.own_data.reading import Reading, Record, Unmeasured, placed
from experiments.recorded import LeftOut, Message
from filter import Polygon, position_from_range_difference

COLUMNS = ("normal_x", "normal_y", "offset")
FARTHER = 1 + 1e-9  # an antenna is taken to reach so much farther out of the arena, for rounding


class DifferenceReading(Reading):
    """How much farther a robot, or an antenna of it, is from one landmark than from another."""

    def __init__(self, channel: Channel, facts: Facts, left_out: LeftOut) -> None:
        super().__init__(channel, facts, left_out)
        reach = FARTHER * _reach(facts, self.stream.sensor)
        lower, upper = np.array(facts.arena)
        self._within = Polygon.box(np.nextafter(lower - reach, -np.inf), np.nextafter(upper + reach, np.inf))

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one record, see `Reading`."""
        places = self._places(message)
        difference = self.door.distance(self.value(message, "difference"))
        with placed(message.place):
            bound = np.array(self.stream.bounds["bound"])
            told = position_from_range_difference(0.0, 0, places, difference, bound, self._within)
        if not len(told.offset):
            raise Unmeasured("its difference excludes nothing of the arena")
        columns = {name: getattr(told, name).tolist() for name in COLUMNS}
        yield self.head("position", stamp) | columns | self.stream.sensors

    def _places(self, message: Message) -> list[list[float]]:
        """Return where the two landmarks are [m]."""
        named = self.stream.landmarks or [str(self.channel.fields[name](message.content)) for name in ("first", "second")]
        first, second = (self._landmark(called.strip()) for called in named)
        if self.facts.landmarks[first] == self.facts.landmarks[second]:
            raise Unmeasured("it names one place twice")
        return [self.facts.landmarks[first], self.facts.landmarks[second]]

    def _landmark(self, called: str) -> str:
        body = self.facts.body(called, self.stream.ids)
        if body is None:
            raise Unmeasured(nobody(called))
        if "landmark" not in body:
            raise Unmeasured(f"{body['target']} is no landmark whose place is known")
        return body["landmark"]


def _reach(facts: Facts, sensor: str) -> float:
    """Return how far from its robot's centre, which is in the arena, an antenna is at most [m]."""
    mounted = facts.sensors.get(sensor, {})
    return math.hypot(*mounted.get("position", (0.0, 0.0))) + float(mounted.get("position_bound", 0.0))
