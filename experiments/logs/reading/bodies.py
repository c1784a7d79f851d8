"""Robots, landmarks and sensors as a log calls them: by numbers, and from version 2 on by names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from reprlib import repr as shortened
from typing import Any

from experiments.logs.records import FIRST, Header
from filter import InvalidInput


@dataclass(frozen=True)
class Bodies:
    """The robots, the landmarks or the sensors that a log knows: by numbers from 0 on, and by names.

    Attributes:
        count: How many.
        names: Each one's number, where names are known.
    """

    count: int
    names: Mapping[str, int]

    @property
    def expected(self) -> str:
        """What can stand for one of them, in words."""
        numbers = f"whole numbers from 0 to {self.count - 1}" if self.count else "nothing, as there is none"
        return f'{numbers}, or names, as "{next(iter(self.names))}"' if self.names else numbers

    def number(self, field: str, body: Any) -> int:
        """Return a body's number; raises `InvalidInput`, with the nearest name, for what is none."""
        if isinstance(body, str) and body in self.names:
            return self.names[body]
        if type(body) is int and 0 <= body < self.count:
            return body
        near = get_close_matches(body, self.names, 1) if isinstance(body, str) else []
        raise InvalidInput(f"{field}: {f'a name, as {near[0]}' if near else self.expected}", shortened(body))


def bodies_of(header: Header) -> tuple[Bodies, Bodies]:
    """Return the robots and the landmarks of a log; in version 1 they have no names."""
    team, names = header.team, header.team.names if header.version > FIRST else ()
    robots, marks = names[: team.robots], names[team.robots :]
    of_robots, of_marks = ({name: number for number, name in enumerate(each)} for each in (robots, marks))
    return Bodies(team.robots, of_robots), Bodies(len(team.landmarks), of_marks)


def sensors_of(header: Header) -> Bodies:
    """Return the sensors of a log."""
    sensors = header.team.sensors
    return Bodies(len(sensors), {sensor.name: number for number, sensor in enumerate(sensors)})
