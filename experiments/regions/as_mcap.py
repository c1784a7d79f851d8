"""Regions as an MCAP file: ROS polygons, a scene for Foxglove, and poses where a Kalman filter has them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import Writer as File

from experiments.regions.files import named
from experiments.regions.ros import POLYGON, POLYGON_DEFINITION, POSE, POSE_DEFINITION, polygon_message, pose_message
from experiments.regions.rounded import rounded_outward
from experiments.regions.rows import Row
from experiments.regions.scene import NAME, definition, scene_message
from experiments.regions.stamps import nanoseconds


class Writer:
    """Writes `regions.mcap`. Only `close` makes it a whole file; what a killed run leaves can be recovered.

    Topics, of a robot r0: `/r0/region` its outer polygon, `/r0/ekf` what a Kalman filter believes; and `/regions`, the scene.

    Raises:
        OSError: It cannot be written, as by each method.
        InvalidInput: A time or a coordinate is none that these messages can hold, as by `write`.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._channels = path, dict[str, int]()
        self._stream = path.open("wb")
        self._file = File(self._stream)
        with named(path):
            self._file.start()
        self._schemas = {name: self._file.register_schema(name, *how) for name, how in _SCHEMAS.items()}

    def write(self, rows: Sequence[Row]) -> None:
        """Append a step."""
        stamp = nanoseconds(rows[0].time)
        for row in rows:
            if row.outer is not None and row.margin is not None:
                polygon = polygon_message(stamp, rounded_outward(row.outer, row.margin))
                self._put(f"/{row.robot}/region", POLYGON, stamp, polygon)
            if row.ekf is not None:
                self._put(f"/{row.robot}/ekf", POSE, stamp, pose_message(stamp, row.ekf))
        if any(row.outer is not None for row in rows):
            self._put("/regions", NAME, stamp, scene_message(stamp, rows))

    def _put(self, topic: str, kind: str, stamp: int, message: bytes) -> None:
        if topic not in self._channels:
            how = MessageEncoding.Protobuf if kind == NAME else MessageEncoding.CDR
            self._channels[topic] = self._file.register_channel(topic, how, self._schemas[kind])
        with named(self._path):
            self._file.add_message(self._channels[topic], stamp, message, stamp)

    def close(self) -> None:
        """Write the end of the file, with its index."""
        with named(self._path):
            try:
                self._file.finish()
            finally:
                self._stream.close()


_SCHEMAS = {
    POLYGON: (SchemaEncoding.ROS2, POLYGON_DEFINITION.encode()),
    POSE: (SchemaEncoding.ROS2, POSE_DEFINITION.encode()),
    NAME: (SchemaEncoding.Protobuf, definition()),
}
