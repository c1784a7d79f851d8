"""What a recording shows of regions, held against the regions that are proved. Standard library only."""

import struct
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from experiments.proof.log import Frame
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
TEAM, PLOTTED = "team", ("mean", "least", "greatest")  # what large teams have instead of an entity for each robot
NANOSECOND, MEAN = 1.0001e-9, 1e-12


def check_recording(path: Path, frames: Sequence[Frame], regions: Sequence[Sequence[Region]]) -> tuple[int, int]:
    """Return how many regions are recorded as they are proved, and how many entities are of no region.

    Args:
        path: The recording.
        frames: All frames of the log.
        regions: Of each frame and robot.

    Raises:
        Broken: It cannot be read, or shows something else, or nothing, of a region.
        OSError: There is no such file.
    """
    with located(path.name):
        every = recorded(path, lambda name: any(name.startswith(layer) for layer in COMPONENTS))
        together, robots = f"{OUTER}{TEAM}" in every, len(regions[0])
        names = [TEAM] if together else [f"r{robot}" for robot in range(robots)]
        plots = [*PLOTTED] if together else names
        shown = {layer: [_rows(every, layer + name, frames) for name in names] for layer in LAYERS}
        areas = [_rows(every, AREA + name, frames) for name in plots]
        for number, of_frame in enumerate(regions):
            for place, group in enumerate([of_frame] if together else [[one] for one in of_frame]):
                _check_layers({layer: rows[place][number] for layer, rows in shown.items()}, number, group)
            _check_areas([rows[number][0] for rows in areas], [region.area for region in of_frame], together)
    return len(frames) * robots, len(every) - len(LAYERS) * len(names) - len(plots)


def _rows(every: dict[str, list[Recorded]], name: str, frames: Sequence[Frame]) -> list[Any]:
    """Return what an entity shows at each frame.

    Raises:
        Broken: It shows something, or nothing, at another time.
    """
    what = COMPONENTS[name[: name.rindex("/") + 1]]
    rows = [row for row in every.get(name, []) if row.values.get(what) is not None]
    same = len(rows) == len(frames) and all(
        row.step == number and abs(row.time - frame.time) <= NANOSECOND
        for number, (row, frame) in enumerate(zip(rows, frames, strict=True))
    )
    if not same:
        raise Broken(f"{name} has {len(rows)} rows, where the log has {len(frames)} frames, or they are of other times")
    return [row.values[what] for row in rows]


def _check_layers(shown: dict[str, Any], number: int, regions: Sequence[Region]) -> None:
    right = {
        OUTER: [[_drawn(point) for point in (*region.vertices, region.vertices[0])] for region in regions],
        FILL: [_drawn(point) for region in regions for point in region.vertices],
        ESTIMATE: [_drawn(region.estimate) for region in regions],
    }
    for layer, points in right.items():
        if _flat(shown[layer]) != points:
            raise Broken(f"{layer} shows another polygon than the one that is proved, in frame {number}")


def _flat(value: Any) -> Any:
    """Return points of a recording in the plane."""
    if value and isinstance(value[0], list):
        return [_flat(one) for one in value]
    return value[:2]


def _drawn(point: Sequence[float | Fraction]) -> list[float]:
    """Return a point as recordings have it, in single precision."""
    return list(struct.unpack("<2f", struct.pack("<2f", *map(float, point))))


def _check_areas(shown: Sequence[float], areas: Sequence[float], together: bool) -> None:
    """Check a number for each robot, or mean, least and greatest."""
    right = [sum(areas) / len(areas), min(areas), max(areas)] if together else areas
    off = MEAN * right[0] if together else 0.0  # means are summed in any order
    if abs(shown[0] - right[0]) > off or list(shown[1:]) != list(right[1:]):
        raise Broken(f"areas of {list(shown)} m2 are shown, where {list(right)} m2 are proved")
