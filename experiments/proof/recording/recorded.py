"""What a recording shows of regions, held against the regions that are proved. Standard library only."""

import struct
from collections.abc import Collection, Sequence
from fractions import Fraction
from itertools import accumulate
from math import isnan, nan
from pathlib import Path
from typing import Any

from experiments.proof.given.frame import Frame
from experiments.proof.reading import Broken, located
from experiments.proof.recording.rrd import Recorded, recorded
from experiments.proof.shown import Region

LAYERS = OUTER, FILL, ESTIMATE = "/world/outer/", "/world/fill/", "/world/estimate/"
AREA = "/area/"
COMPONENTS = {
    OUTER: "LineStrips3D:strips",
    FILL: "Mesh3D:vertex_positions",
    ESTIMATE: "Points3D:positions",
    AREA: "Scalars:scalars",
}
TRIANGLES = "Mesh3D:triangle_indices"
# The columns that entities of regions may have; and those on the way to them, whose transforms would move these, too.
MARKS = {"step", "t", "rerun.controls.RowId"}
KINDS = {OUTER: {"LineStrips3D"}, FILL: {"Mesh3D"}, ESTIMATE: {"Points3D"}, AREA: {"Scalars", "SeriesLines"}}
ABOVE, UP = {"/", "/world", *(layer.rstrip("/") for layer in COMPONENTS)}, {"ViewCoordinates"}
TEAM, PLOTTED = "team", ("mean", "least", "greatest")  # what large teams have instead of an entity for each robot
NANOSECOND, MEAN = 1.0001e-9, 1e-12


def check_recording(
    path: Path, robots: Sequence[str], frames: Sequence[Frame], regions: Sequence[Sequence[Region | None]]
) -> tuple[int, int]:
    """Return how many regions are recorded as they are proved, and how many entities are of no region.

    Args:
        path: The recording.
        robots: What they are called.
        frames: All frames of the log.
        regions: Of each frame and robot; None of one that is away, of which nothing is shown.

    Raises:
        Broken: It cannot be read, or shows something else, or nothing, of a region.
        OSError: There is no such file.
    """
    with located(path.name):
        every = recorded(path, lambda name: name in ABOVE or any(name.startswith(layer) for layer in COMPONENTS))
        for name, rows in every.items():
            _check_kinds(name, rows)
        together = TEAM not in robots and f"{OUTER}{TEAM}" in every
        names = [TEAM] if together else [*robots]
        plots = [*PLOTTED] if together else names
        shown = {layer: [_rows(every, layer + name, frames) for name in names] for layer in LAYERS}
        fans = [_rows(every, FILL + name, frames, TRIANGLES) for name in names]
        nobody = [number for number, of_frame in enumerate(regions) if together and not any(of_frame)]
        areas = [_rows(every, AREA + name, frames, without=nobody) for name in plots]
        for number, of_frame in enumerate(regions):
            for place, some in enumerate([of_frame] if together else [[one] for one in of_frame]):
                group = [one for one in some if one]
                _check_layers({layer: rows[place][number] for layer, rows in shown.items()}, number, group)
                if [list(corners) for corners in fans[place][number]] != _fans([len(one.vertices) for one in group]):
                    raise Broken(f"{FILL} fills another polygon than the one that is proved, in frame {number}")
            if number not in nobody:
                _check_areas([rows[number][0] for rows in areas], of_frame, together)
    return sum(one is not None for of_frame in regions for one in of_frame), len(every) - len(LAYERS) * len(names) - len(plots)


def _check_kinds(name: str, rows: Sequence[Recorded]) -> None:
    """Raise `Broken` if an entity of a region, or one above it, has something that changes how regions are shown."""
    allowed = UP if name in ABOVE else KINDS.get(name[: name.rindex("/") + 1])
    columns = {column for row in rows for column in row.values} - MARKS
    if allowed is not None and not {column.split(":")[0] for column in columns} <= allowed:
        raise Broken(f"{name} has columns {sorted(columns)}, where those of {sorted(allowed)} were expected")


def _rows(
    every: dict[str, list[Recorded]], name: str, frames: Sequence[Frame], what: str = "", without: Collection[int] = ()
) -> dict[int, Any]:
    """Return what an entity shows at each frame but some, by its layer's component or another one.

    Raises:
        Broken: It shows something, or nothing, at another time.
    """
    what = what or COMPONENTS[name[: name.rindex("/") + 1]]
    rows = [row for row in every.get(name, []) if row.values.get(what) is not None]
    asked = [(number, frame.time) for number, frame in enumerate(frames) if number not in without]
    same = len(rows) == len(asked) and all(
        row.step == number and abs(row.time - time) <= NANOSECOND for row, (number, time) in zip(rows, asked, strict=True)
    )
    if not same:
        raise Broken(f"{name} has {len(rows)} rows, where the log has {len(asked)} frames, or they are of other times")
    return {number: row.values[what] for row, (number, _) in zip(rows, asked, strict=True)}


def _check_layers(shown: dict[str, Any], number: int, regions: Sequence[Region]) -> None:
    right = {
        OUTER: [[_drawn(point) for point in (*region.vertices, region.vertices[0])] for region in regions],
        FILL: [_drawn(point) for region in regions for point in region.vertices],
        ESTIMATE: [_drawn(region.estimate) for region in regions],
    }
    for layer, points in right.items():
        heights = set[float]()
        if _flat(shown[layer], heights) != points or len(heights) != min(1, len(regions)):
            raise Broken(f"{layer} shows another polygon than the one that is proved, in frame {number}")


def _fans(sizes: Sequence[int]) -> list[list[int]]:
    """Return the corners of the triangles that fill polygons of so many corners, one after the other."""
    ends = accumulate(sizes)
    return [
        [end - size, end - size + k, end - size + k + 1]
        for size, end in zip(sizes, ends, strict=True)
        for k in range(1, size - 1)
    ]


def _flat(value: Any, heights: set[float]) -> Any:
    """Return points of a recording in the plane; collect the heights that they are shown at."""
    if value and isinstance(value[0], list):
        return [_flat(one, heights) for one in value]
    heights.update(value[2:])
    return value[:2]


def _drawn(point: Sequence[float | Fraction]) -> list[float]:
    """Return a point as recordings have it, in single precision."""
    return list(struct.unpack("<2f", struct.pack("<2f", *map(float, point))))


def _check_areas(shown: Sequence[float], regions: Sequence[Region | None], together: bool) -> None:
    """Check a number for each robot, none of one that is away, or mean, least and greatest."""
    areas = [one.area for one in regions if one]
    right = [sum(areas) / len(areas), min(areas), max(areas)] if together else [one.area if one else nan for one in regions]
    off = [MEAN * right[0], 0.0, 0.0] if together else [0.0] * len(right)  # means are summed in any order
    for one, other, by in zip(shown, right, off, strict=True):
        if not (abs(one - other) <= by or (isnan(one) and isnan(other))):
            raise Broken(f"areas of {list(shown)} m2 are shown, where {right} m2 are proved")
