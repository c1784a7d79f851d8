"""What is compiled to machine code (numba): where it is kept, what is said of it, and what survives an interrupt.

Numba keeps compiled functions on disk, but looks only at the file a function is in, not at what it calls. So the folder
where they are kept is named after the contents of the whole filter: a change to a file of it makes all of them new.

**What is compiled.** Only what Python calls. All that a compiled function calls is a part of it, optimised and translated
there, once, and not on each level on the way, as numba does by itself.

**What Python calls** takes arrays, numbers, tuples and named tuples, no lists; it returns nothing, numbers, a tuple of numbers,
or one array that it has made, and writes whatever else it finds into arrays that its caller has made. For numba calls Python to
hand out an array or a named tuple, and there a signal's handler may raise: the exception is then lost, or the process crashes.
Among themselves compiled functions are free. Arrays go into a part of another by `put` or by loops, not by a slice: once a
process and once more for each array, numba would take seconds to compile the words of the error for shapes that differ. Sums,
the least and the greatest are those below, not numpy's, and numbers are rounded by `rint`: with what numba has of numpy's own
arithmetic, loading would import scipy's linear algebra, which takes longer than all else.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.runtime.nrt import rtsys
from numba.misc.appdirs import user_cache_dir

from filter.workers import spread

Function = TypeVar("Function", bound=Callable[..., Any])

FOLDER = Path(__file__).parent
SETTINGS = cast(Any, numba).config
MADE: list[Any] = []  # all compiled functions


def _folders() -> Iterator[Path]:
    """Yield where compiled functions may be kept: in NUMBA_CACHE_DIR, beside Python's own, or in a folder of the user's."""
    if SETTINGS.CACHE_DIR:
        yield Path(SETTINGS.CACHE_DIR).absolute()
    yield FOLDER / "__pycache__"
    caches = Path(user_cache_dir("corral", appauthor=False))
    if caches.is_absolute():  # there is no home, else
        yield caches
    if hasattr(os, "getuid"):
        with suppress(OSError):
            temporary = Path(tempfile.gettempdir(), f"corral-{os.getuid()}")
            temporary.mkdir(mode=0o700, exist_ok=True)
            if _is_mine(temporary):
                yield temporary


def _is_mine(folder: Path) -> bool:
    """Return whether nobody else can have put anything into a folder: code would be loaded from it."""
    status = folder.lstat()
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o077


def _place() -> str | None:
    """Return the folder for this version of what is compiled, or None where nothing can be written."""
    version = hashlib.sha256(numba.__version__.encode())
    for path in sorted(FOLDER.rglob("*.py")):
        version.update(b"\0" + path.read_bytes())
    for folder in _folders():
        with suppress(OSError):
            place = folder / f"corral-{version.hexdigest()[:16]}"
            place.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=place).close()
            return str(place)
    return None


PLACE = _place()


class _Kept:
    """A function's compiled forms on disk, without what is broken or not what was asked for."""

    def __init__(self, cache: Any) -> None:
        self._cache, self.cache_path = cache, cache.cache_path

    def load_overload(self, types: tuple[Any, ...], target: Any) -> Any:
        """Return what is kept for arguments of such types, or None; numba calls this.

        Numba's own way would first import all that it can compile, which takes half a second; to load, its memory is enough.
        """
        try:
            rtsys.initialize(target)
            kept = self._cache._load_overload(types, target)
        except Exception:  # whatever unpickling a file raises that was cut off
            with suppress(OSError):
                self._cache.flush()
            return None
        # Two processes that keep two forms of one function at a time can mix up their files.
        return kept if kept is not None and kept.signature.args == types else None

    def save_overload(self, types: tuple[Any, ...], made: Any) -> None:
        """Keep a form if it can be; numba calls this."""
        with suppress(OSError):  # the disk is full by now
            self._cache.save_overload(types, made)


class _Says(event.Listener):
    """Says that something is compiled: one line on stderr in the life of a process, none when all is loaded."""

    said = False

    def on_start(self, event: Any) -> None:
        if not self.said and event.data["dispatcher"] in MADE:
            self.said = True
            kept = f"kept in {PLACE}" if PLACE else "kept nowhere, as no folder can be written; set NUMBA_CACHE_DIR to one"
            with suppress(OSError, ValueError, AttributeError):  # stderr is closed, or there is none
                sys.stderr.write(f"corral: compiling for this machine, once, for a minute or so ({kept})\n")

    def on_end(self, event: Any) -> None:
        """Nothing is said."""


event.register("numba:compile", _Says())


class _Part(JITCodeLibrary):
    """The code of a function that is a part of others: it is never optimised, translated or run by itself."""

    def _optimize_final_module(self) -> None:
        """Leave it as it is."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:  # noqa: ARG002
        """Return that there is none."""
        return 0

    @property
    def codegen(self) -> _Part:
        """What numba tells the environment that Python would call it in."""
        return self

    def set_env(self, name: str, env: Any) -> None:
        """Do nothing: Python does not call it."""


class _PartCompiler(Compiler):
    def compile_extra(self, function: Any) -> Any:
        """Compile a function as a part; numba calls this."""
        self.state.library = _Part(self.state.targetctx.codegen(), function.__qualname__)
        return super().compile_extra(function)


class _Whole(CPUDispatcher):
    """A function that Python can call. To compiled functions that call it, it is a part of theirs."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function, targetoptions={"nopython": True, "nogil": True})
        options = {"nopython": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        self.part = CPUDispatcher(function, targetoptions=options, pipeline_class=_PartCompiler)

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.part)


def compiled(function: Function) -> Function:
    """Return the function compiled when it is first called, and loaded from disk from then on; it lets other threads run."""
    if SETTINGS.DISABLE_JIT:  # NUMBA_DISABLE_JIT: to step through
        return function
    made: Any = _Whole(function)
    if PLACE is not None:
        before, SETTINGS.CACHE_DIR = SETTINGS.CACHE_DIR, PLACE
        try:
            made.enable_caching()
        finally:
            SETTINGS.CACHE_DIR = before
        made._cache = _Kept(made._cache)
    made._compile_for_args = partial(_aside, made._compile_for_args)
    MADE.append(made)
    return cast(Function, made)


def _aside(make: Callable[..., Any], *arguments: Any) -> Any:
    """Let numba compile or load a function in a thread of its own; interrupted, it would not work any more, or crash."""
    return spread(lambda given: make(*given), [arguments], threads=1)[0]


@compiled
def put(values: Any, into: Any) -> None:
    """Write values (k,) into the beginning of a row."""
    for k in range(len(values)):
        into[k] = values[k]


@compiled
def sum_of(values: Any) -> Any:
    """Return the sum of values (k,), added up in their order."""
    found = 0
    for value in values:
        found += value
    return found


@compiled
def place_of_least(values: Any) -> int:
    """Return the place of the least of values (k,), and of the first of several."""
    place = 0
    for k in range(1, len(values)):
        if values[k] < values[place]:
            place = k
    return place


@compiled
def bounds_of(values: Any) -> tuple[float, float]:
    """Return the least and the greatest of values (k,), one at least."""
    least = greatest = values[0]
    for value in values:
        least, greatest = min(least, value), max(greatest, value)
    return least, greatest
