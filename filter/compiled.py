"""What is compiled to machine code (numba), once for each machine and version of this folder.

Numba keeps compiled functions on disk, but looks only at the file a function is in, not at what it calls. So the place
where they are kept is named after the contents of all compiled modules: a change to one makes all of them new.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

FOLDER = Path(__file__).parent
SETTINGS = cast(Any, numba).config


def _place() -> str:
    """Return the folder for what is compiled: under the caller's NUMBA_CACHE_DIR, or beside Python's own compiled files."""
    texts = [text for text in (path.read_bytes() for path in sorted(FOLDER.rglob("*.py"))) if b"\n@compiled\n" in text]
    version = hashlib.sha256(b"\0".join(texts)).hexdigest()[:16]
    return str(Path(SETTINGS.CACHE_DIR or FOLDER / "__pycache__") / f"corral-{version}")


PLACE = _place()


def compiled(function: Function) -> Function:
    """Return the function compiled when it is first called, and loaded from disk from then on; it lets other threads run."""
    before, SETTINGS.CACHE_DIR = SETTINGS.CACHE_DIR, PLACE
    try:
        return cast(Function, numba.njit(cache=True, nogil=True)(function))
    finally:
        SETTINGS.CACHE_DIR = before
