"""What all readings have in common: from the messages of one channel to records of the log."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from experiments.own_data.channels import Channel
from experiments.own_data.facts import Facts
from experiments.own_data.units import seconds, yaw
from experiments.recorded import LeftOut, Message
from filter import InvalidInput

Record = dict[str, Any]
NO_ROTATION = "its orientation is a quaternion whose length is not 1"


class Unmeasured(Exception):
    """A message, or an entry of it, says nothing that could be recorded; the text is why."""


class Reading(ABC):
    """Makes records from the messages of one channel. What says nothing is counted and left out."""

    def __init__(self, channel: Channel, facts: Facts, left_out: LeftOut) -> None:
        self.channel, self.stream, self.door = channel, channel.stream, channel.stream.door
        self.facts, self._left_out = facts, left_out

    @abstractmethod
    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield the records of a message.

        Args:
            message: One of the channel's topic.
            stamp: When [ns].

        Raises:
            InvalidInput: Something in it is no number, or a number that cannot be meant.
            Unmeasured: It says nothing.
        """

    def skip(self, why: object, things: str = "messages") -> None:
        """Count something that is left out."""
        self._left_out.add(self.channel.topic.name, str(why), 1, things)

    def head(self, kind: str, stamp: int) -> Record:
        """Return what every record of an instant [ns] begins with."""
        return {"record": kind, "time": seconds(stamp), "robot": self.stream.robot}

    def value(self, message: Message, name: str) -> float:
        """Return a field as a number."""
        return number(self.channel.fields[name](message.content), name, message.place)

    def bound(self, name: str) -> float:
        """Return a bound that is one number."""
        return float(str(self.stream.bounds[name]))

    def deviations(self, name: str, variance: Any, place: str) -> float:
        """Return k_sigma standard deviations, in the message's own unit."""
        return self.stream.k_sigma * deviation(variance, name, place)

    def heading(self, message: Message) -> float:
        """Return the heading, of a field of that name or of a quaternion [rad]."""
        if "heading" in self.channel.fields:
            with placed(message.place):
                return self.door.heading(self.value(message, "heading"))
        parts = self.channel.fields["orientation"](message.content)
        turned = yaw(*(number(part, "orientation", message.place) for part in parts))
        if turned is None:
            raise Unmeasured(NO_ROTATION)
        return self.door.heading_of_yaw(turned)


def number(value: Any, name: str, place: str) -> float:
    """Return a number, of a message or of a text.

    Raises:
        Unmeasured: There is nothing, NaN or an infinity.
        InvalidInput: It is something else.
    """
    if isinstance(value, str) and not value.strip():
        raise Unmeasured(f"nothing in {name}")
    try:
        found = float(value)
    except (TypeError, ValueError):
        raise InvalidInput(f"{place}: {name}: a number", repr(value)) from None
    if not math.isfinite(found):
        raise Unmeasured(f"{name} is not a finite number")
    return found


def deviation(variance: Any, bound: str, place: str) -> float:
    """Return the standard deviation of a variance, of a message or of a text.

    Raises:
        InvalidInput: It is 0 or less, by which messages say that nobody knows it.
        Unmeasured: There is nothing, NaN or an infinity.
    """
    value = number(variance, "its variance", place)
    if value <= 0:
        raise InvalidInput(f'{place}: a variance above 0, to take k_sigma deviations of; else declare "{bound}"', repr(value))
    return math.sqrt(value)


@contextmanager
def placed(place: str) -> Iterator[None]:
    """Say of an error where the value is that it is about."""
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput(f"{place}: {error.expected}", error.came) from None
