"""Where in a message a value is: "pose.position.x", "covariance[8]", "detections[*].bearing" for one of each detection."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from experiments.recorded.words import nearest
from filter import InvalidInput

ONE_STEP = re.compile(r"\.?([A-Za-z]\w*)|\[(\*|\d+)\]")
EACH = "*"
PathStep = str | int  # a field, an element, or each element
TypeFields = Mapping[str, tuple[Any, Sequence[tuple[str, Any]]]]  # by type: constants, and fields
BASE, NAME = 1, 2  # what a field is, in rosbags' words; anything else is an array


def steps_of(path: str) -> list[PathStep]:
    """Return the steps of a path.

    Raises:
        InvalidInput: It is none, or it goes over two arrays.
    """
    found, at = list[PathStep](), 0
    while at < len(path):
        match = ONE_STEP.match(path, at)
        if match is None or (at == 0 and path.startswith(".")):
            raise InvalidInput('a path as in "pose.position.x" or "detections[*].bearing"', repr(path))
        name, index = match.groups()
        found.append(name or (EACH if index == EACH else int(index)))
        at = match.end()
    if not found or found.count(EACH) > 1:
        raise InvalidInput("a path that goes over the elements of one array at most", repr(path))
    return found


def follow(value: Any, steps: Sequence[PathStep]) -> Any:
    """Return what is at the end of a path; a list of them, after a [*]."""
    for number, step in enumerate(steps):
        if step == EACH:
            return [follow(each, steps[number + 1 :]) for each in value]
        value = value[step] if isinstance(step, int) else getattr(value, step)
    return value


def check_path(path: str, message: str, types: TypeFields) -> None:
    """Refuse a path that a type of messages does not have.

    Raises:
        InvalidInput: There is no such field, or it is an array where it should not be, or the reverse.
    """
    at: Any = (NAME, message)
    for step in steps_of(path):
        sort, inner = at
        is_index = step == EACH or isinstance(step, int)
        if sort in (NAME, BASE) and is_index:
            raise InvalidInput(f'"{path}": an array before [{step}]', inner if sort == NAME else inner[0])
        if sort == BASE:
            raise InvalidInput(f'"{path}": nothing after a {inner[0]}', f'"{step}"')
        if sort != NAME and not is_index:
            raise InvalidInput(f'"{path}": [*], or the number of an element as in [0], before "{step}"', "neither")
        at = inner[0] if is_index else _field(path, str(step), inner, types)


def _field(path: str, name: str, message: str, types: TypeFields) -> Any:
    fields = dict(types[message][1])
    if name not in fields:
        raise InvalidInput(f'"{path}": a field of {message}: {nearest(name, fields)}', f'"{name}"')
    return fields[name]


def compiled_path(path: str) -> Callable[[Any], Any]:
    """Return a function that returns what is at the end of a path in a message."""
    steps = steps_of(path)
    return lambda message: follow(message, steps)
