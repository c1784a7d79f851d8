"""What the lines of a feed say: first the header and the initial sets, then records; a line at fault is told, not the end."""

from __future__ import annotations

from codecs import BOM_UTF8
from pathlib import Path

from experiments.feeds.intake import Line
from experiments.feeds.lines import MOST
from experiments.logs import Header, InitialSet, InvalidLog, Record
from experiments.logs.reading.bodies import bodies_of
from experiments.logs.reading.fast import Fast
from experiments.logs.reading.fields import Fields
from experiments.logs.reading.heads import read_header, read_initial
from experiments.logs.reading.strict import Strict
from filter import InvalidInput


class Reading:
    """Reads lines, strictly.

    Attributes:
        initial: What is known of each robot at the start, in the robots' order, once all is known.
    """

    def __init__(self, name: str) -> None:
        """Prepare for lines of a source of that name."""
        self._name, self._said = name, set[bytes]()
        self._header: Header | None = None
        self._found = dict[int, InitialSet]()
        self.initial: tuple[InitialSet, ...] = ()

    @property
    def header(self) -> Header:
        """What the feed began with; to be asked once the initial sets are known."""
        if self._header is None:
            raise InvalidInput("a feed with a header", "none")
        return self._header

    def read(self, line: Line) -> Record | None:
        """Return a record, or None for a line that says nothing new: of the head, or blank.

        Raises:
            InvalidLog: The head of the feed is not as docs/log.md says: nothing can be read then.
            InvalidInput: The line is not.
        """
        if line.text is None:
            self._refused(line)
            return None
        text = line.text.removeprefix(BOM_UTF8)
        if not text.strip() or text.strip() in self._said:  # who connects again says the same once more
            return None
        if self.initial:
            record = self._fast.read(text)
            return self._strict.read(Fields.parse(text)) if record is None else record
        try:
            self._begin(text)
        except InvalidInput as error:
            raise InvalidLog(Path(self._name), line.number, error.expected, error.came) from None
        self._said.add(text.strip())
        return None

    def _refused(self, line: Line) -> None:
        """Refuse a line that is too long if it is of the head."""
        if not self.initial:
            raise InvalidLog(Path(self._name), line.number, f"a line of at most {MOST} bytes", "a longer one")

    def _begin(self, text: bytes) -> None:
        """Read a line of the head."""
        if self._header is None:
            self._header = read_header(Fields.parse(text))
            self._fast, self._strict = Fast(self._header), Strict(self._header)
            return
        robots, _ = bodies_of(self._header)
        robot, known = read_initial(Fields.parse(text), robots, self._found)
        self._found[robot] = known
        if len(self._found) == robots.count:
            self.initial = tuple(self._found[robot] for robot in range(robots.count))
