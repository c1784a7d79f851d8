"""Rows of one entity as Rerun's columns, which are sent ten times faster than row by row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr

from experiments.show.drawing import Arrows, Fans, Number, Points, Strips, triangles_of

NO_POINTS = np.zeros((0, 3))


def columns_of(items: Sequence[Any]) -> list[Any]:
    """Return Rerun's columns of one entity's rows, which are all of one type."""
    match items[0]:
        case Strips():
            lines = [line for item in items for line in item.lines]
            return [*rr.LineStrips3D.columns(strips=lines).partition([len(item.lines) for item in items])]
        case Points():
            positions = np.concatenate([item.positions for item in items])
            return [*rr.Points3D.columns(positions=positions).partition([len(item.positions) for item in items])]
        case Arrows():
            origins, vectors = (np.concatenate([getattr(item, name) for item in items]) for name in ("origins", "vectors"))
            return [*rr.Arrows3D.columns(origins=origins, vectors=vectors).partition([len(item.origins) for item in items])]
        case Fans():
            return _fans(items)
        case Number():
            return [*rr.Scalars.columns(scalars=[item.value for item in items])]
    texts, levels = zip(*items, strict=True)
    return [*rr.TextLog.columns(text=texts, level=levels)]


def _fans(items: Sequence[Fans]) -> list[Any]:
    points = [np.concatenate([NO_POINTS, *item.polygons]) for item in items]
    triangles = [triangles_of([len(vertices) for vertices in item.polygons]) for item in items]
    corners = rr.Mesh3D.columns(vertex_positions=np.concatenate(points)).partition([len(each) for each in points])
    indices = rr.Mesh3D.columns(triangle_indices=np.concatenate(triangles)).partition([len(each) for each in triangles])
    return [*corners, *indices]
