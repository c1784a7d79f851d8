"""Forgeries: what is changed in the files of a run that was proved, and why it has to be refused."""

from collections.abc import Callable
from typing import Any, NamedTuple

from helpers.proved.runs import forge

from experiments import prove

LOG = "log.jsonl"


class Forgery(NamedTuple):
    """A change of a file.

    Attributes:
        change: Changes the records of the file in place.
        why: Words of the refusal.
        file: Of the run.
        run: Of which run, where there are several.
    """

    change: Callable[..., Any]
    why: str
    file: str
    run: Any


class Forgeries(dict):
    """Forgeries by name; to call it is to enter one, as a decorator."""

    def __call__(self, why, file=LOG, run=None):
        """Return what enters a function that changes the records of a file, with the reason of the refusal."""

        def entered(change):
            self[change.__name__] = Forgery(change, why, file, run)
            return change

        return entered


def check_refused(folder, forgery, capsys):
    """Forge a copy of a run, and check that it is refused for this reason."""
    forge(folder, forgery.file, forgery.change)
    assert prove.main([str(folder)]) == 1
    told = capsys.readouterr().out
    assert told.startswith("not proved: ")
    assert forgery.why in told, told
