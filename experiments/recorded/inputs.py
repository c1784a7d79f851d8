"""What a conversion reads: topics, and the messages of those that are wanted, as they arrived. And what is left out of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any, NamedTuple, Protocol

Taker = Callable[[Any], Any]
EACH_TIME = "messages"


class Topic(NamedTuple):
    """A topic of a bag, or a file of a folder.

    Attributes:
        name: The topic's or the file's, as the settings name it.
        type: Of its messages, "package/msg/Name", or "CSV".
        size: So many messages, or rows.
        missing: Why its messages cannot be read, or "".
        fields: The names of the columns; none of a bag's.
    """

    name: str
    type: str
    size: int
    missing: str = ""
    fields: Sequence[str] = ()


class Message(NamedTuple):
    """One message or row.

    Attributes:
        topic: Name of the topic or file.
        place: Which one it is, for errors.
        received: When the recorder had it [ns]; None where nobody wrote that down.
        content: What the takers of its topic take values from.
    """

    topic: str
    place: str
    received: int | None
    content: Any


class Input(Protocol):
    """A bag, or a folder of CSV files. Use as a context manager.

    Attributes:
        key: What the settings call a stream's source: "topic" or "file".
    """

    key: str

    @property
    def topics(self) -> Sequence[Topic]:
        """All that are there, by name."""

    def taker(self, topic: Topic, path: str) -> Taker:
        """Return a function that takes a value from a message's content; a list, if there are several in each.

        Raises:
            InvalidInput: There is no such field or column.
        """

    def has_field(self, topic: Topic, path: str) -> bool:
        """Return whether there is such a field or column."""

    def flows(self, topics: Collection[str]) -> list[Iterator[Message]]:
        """Return the messages of some topics: those of a bag in the order of arrival, those of files file by file.

        Raises:
            InvalidInput: Later, on the way: what is there is damaged.
        """


class LeftOut:
    """Counts what could not be read, topic by topic."""

    def __init__(self) -> None:
        self._counts: dict[str, Counter[tuple[str, str]]] = {}

    def add(self, topic: str, why: str, count: int = 1, things: str = EACH_TIME) -> None:
        """Count something of a topic that is left out."""
        self._counts.setdefault(topic, Counter())[why, things] += count

    def has(self, topic: str) -> bool:
        """Return whether something of a topic was left out."""
        return topic in self._counts

    def lines(self, topics: Sequence[Topic]) -> list[str]:
        """Return one line for each topic and reason."""
        return [
            f"left out: {topic.name}, {topic.type}, {_so_many(count, topic.size, things)}: {why}"
            for topic in topics
            for (why, things), count in self._counts.get(topic.name, Counter()).items()
        ]


def _so_many(count: int, all_: int, things: str) -> str:
    """Return how many, of how many if these are not all of them."""
    return f"{count} of {all_} {things}" if things == EACH_TIME and count != all_ else f"{count} {things}"
