"""What the lines of a feed say: first the header and the initial sets, then records; a line at fault is told, not the end."""

from __future__ import annotations

from codecs import BOM_UTF8
from pathlib import Path

from experiments.feeds.intake import Line
from experiments.feeds.lines import MOST
from experiments.logs import Header, InitialSet, InvalidLog, Record
from experiments.logs.reading.fast import Fast
from experiments.logs.reading.fields import Fields
from experiments.logs.reading.heads import InitialSets, read_header
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
        if not self.initial and self._is_head(text, line.number):
            self._said.add(text.strip())
            return None
        record = self._fast.read(text)
        return self._strict.read(Fields.parse(text)) if record is None else record

    def _refused(self, line: Line) -> None:
        """Refuse a line that is too long if it is of the head."""
        if not self.initial:
            raise InvalidLog(Path(self._name), line.number, f"a line of at most {MOST} bytes", "a longer one")

    def _is_head(self, text: bytes, number: int) -> bool:
        """Take in a line of the head; return whether it is one."""
        try:
            record = Fields.parse(text)
            if self._header is None:
                self._begin(record)
                return True
            taken = self._sets.take(record)
        except InvalidInput as error:
            raise InvalidLog(Path(self._name), number, error.expected, error.came) from None
        if not taken or self._sets.are_all_there:
            self.initial = self._sets.sets()
        return taken

    def _begin(self, record: Fields) -> None:
        self._header = header = read_header(record)
        self._sets, self._fast, self._strict = InitialSets(header), Fast(header), Strict(header)
