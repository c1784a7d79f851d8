"""Numbers, rows, sources and regions as certificates write them: every float as a C99 hexadecimal string, which is exact."""

from __future__ import annotations

from typing import Any

from filter import Array, Polygon, Source
from filter.linear.constraints import Constraints

VERSION = 3  # of the format of certificates, in every line


def row_record(rows: Constraints, row: int) -> dict[str, Any]:
    """Return one of some rows."""
    return {
        "i": int(rows.i[row]),
        "j": int(rows.j[row]),
        "normal": hexadecimal(rows.normal[row]),
        "offset": float(rows.offset[row]).hex(),
    }


def region_record(outer: Polygon) -> dict[str, Any]:
    """Return a region as recordings, trajectories and summaries show it."""
    vertices = [hexadecimal(vertex) for vertex in outer.vertices]
    return {"vertices": vertices, "area": float(outer.area).hex(), "estimate": hexadecimal(outer.centroid)}


def source_record(source: Source) -> dict[str, Any]:
    """Return what produced a row."""
    return {"kind": source.kind, "t": source.time.hex(), "robot": source.robot, "target": source.target}


def hexadecimal(values: Array) -> list[str]:
    """Return floats as C99 hexadecimal strings."""
    return [value.hex() for value in values.tolist()]
