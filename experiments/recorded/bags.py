"""Recordings of ROS 1 and ROS 2, read by rosbags; ROS itself is not needed."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from experiments.recorded.inputs import Message, Taker, Topic
from experiments.recorded.paths import check_path, compiled_path
from filter import CorralError, InvalidInput

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys.store import Typestore

ENDINGS = (".bag", ".mcap", ".db3")
MENDING = {".bag": "rosbag reindex", ".mcap": "mcap recover", ".db3": "ros2 bag reindex"}


class Bag:
    """A recording: a ROS 1 bag, a folder of rosbag2, or a file .mcap or .db3 alone. Use as a context manager.

    Attributes:
        key: "topic".
        topics: All topics.

    Raises:
        InvalidInput: The package that reads it is not there, it cannot be read, or it has no definitions of its messages.
    """

    key = "topic"

    def __init__(self, path: Path, types: str, definitions: Collection[Path]) -> None:
        self._path, self._types_said = path, types
        with self._readable():
            self._reader = _reader(path)
            self._reader.open()
            if types or definitions:
                self._know(_typestore(types, definitions))
        remedy = 'types = "humble", or whichever ROS 2 it is from' if not types else 'definitions = ["package/msg/Name.msg"]'
        missing = f"the definition of its type is missing; in the settings, [input] {remedy}"
        of_topic = groupby(sorted(self._reader.connections, key=lambda one: one.topic), key=lambda one: one.topic)
        self.topics = [_topic(name, list(several), missing, self._types) for name, several in of_topic]

    def _know(self, others: Typestore) -> None:
        """Learn the types that the recording itself does not define."""
        known = self._reader.typestore
        known.register({name: fields for name, fields in others.fielddefs.items() if name not in known.fielddefs})

    @property
    def _types(self) -> dict[str, Any]:
        return dict(self._reader.typestore.fielddefs)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._reader.close()

    def has_field(self, topic: Topic, path: str) -> bool:
        """Return whether messages of a topic have a field."""
        try:
            check_path(path, topic.type, self._types)
        except InvalidInput:
            return False
        return True

    def taker(self, topic: Topic, path: str) -> Taker:
        """Return a function that takes a value from a message; a list of them, if the path goes over an array.

        Raises:
            InvalidInput: Messages of the topic have no such field.
        """
        check_path(path, topic.type, self._types)
        return compiled_path(path)

    def flows(self, topics: Collection[str]) -> list[Iterator[Message]]:
        """Return the messages of some topics in the order in which they were received."""
        return [self._messages(set(topics))]

    def _messages(self, topics: set[str]) -> Iterator[Message]:
        connections = [one for one in self._reader.connections if one.topic in topics]
        counts = dict.fromkeys(topics, 0)
        with self._readable():
            for one, received, raw in self._reader.messages(connections=connections) if connections else ():
                counts[one.topic] += 1
                content = self._reader.deserialize(raw, one.msgtype)
                yield Message(one.topic, f"{one.topic}, message {counts[one.topic]}", received, content)

    @contextmanager
    def _readable(self) -> Iterator[None]:
        """Let nothing escape that a library raises over a file that is damaged: what it may raise, it does not say."""
        try:
            yield
        except (CorralError, GeneratorExit):
            raise
        except Exception as error:
            remedy = MENDING.get(self._path.suffix, "ros2 bag reindex")
            types = f", with messages as ROS 2 {self._types_said} has them" if self._types_said else ""
            expected = f"{self._path}: a whole recording{types}; one that was cut off is mended by {remedy}"
            raise InvalidInput(expected, f"{type(error).__name__}: {error}") from None


def _reader(path: Path) -> AnyReader:
    try:
        from rosbags.highlevel import AnyReader  # noqa: PLC0415 - an optional package
    except ImportError:
        raise InvalidInput("rosbags, to read recordings: pip install 'corral[data]'", "no such package") from None
    return AnyReader([path], default_typestore=_typestore("", ()))


def _typestore(types: str, definitions: Collection[Path]) -> Typestore:
    """Return the types of a distribution of ROS 2, none for "", with those that files define."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415 - an optional package

    store = get_typestore(Stores(f"ros2_{types}") if types else Stores.EMPTY)
    for path in definitions:
        name = "/".join((*path.absolute().parts[-3:-1], path.stem))
        store.register(get_types_from_msg(path.read_text(encoding="utf-8"), name))
    return store


def _topic(name: str, connections: list[Any], missing: str, types: dict[str, Any]) -> Topic:
    kinds = sorted({one.msgtype for one in connections})
    count = sum(one.msgcount for one in connections)
    why = missing if kinds[0] not in types else ""
    if len(kinds) > 1:
        why = f"messages of several types: {', '.join(kinds)}"
    return Topic(name, kinds[0], count, why)
