"""Regions as an MCAP file of ROS 2 alone: polygons, and poses where a Kalman filter has them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import Writer as File

from experiments.regions.files import named
from experiments.regions.ros import POLYGON, POLYGON_DEFINITION, POSE, POSE_DEFINITION, polygon_message, pose_message
from experiments.regions.rounded import rounded_outward
from experiments.regions.rows import Row
from experiments.regions.stamps import nanoseconds

Kind = tuple[str, str, bytes, str]  # name, encoding and text of a message's definition, and how messages are encoded
POLYGONS: Kind = (POLYGON, SchemaEncoding.ROS2, POLYGON_DEFINITION.encode(), MessageEncoding.CDR)
POSES: Kind = (POSE, SchemaEncoding.ROS2, POSE_DEFINITION.encode(), MessageEncoding.CDR)


class Writer:
    """Writes `regions_ros2.mcap`. Only `close` makes it a whole file; what a killed run leaves can be recovered.

    Topics, of a robot r0: `/r0/region` its outer polygon, `/r0/ekf` what a Kalman filter believes.

    Raises:
        OSError: It cannot be written, as by each method.
        InvalidInput: A time or a coordinate is none that these messages can hold, as by `write`.
    """

    profile = "ros2"

    def __init__(self, path: Path) -> None:
        self._path, self._schemas, self._channels = path, dict[str, int](), dict[str, int]()
        self._stream = path.open("wb")
        self._file = File(self._stream)
        with named(path):
            self._file.start(self.profile)

    def write(self, rows: Sequence[Row]) -> None:
        """Append a step."""
        stamp = nanoseconds(rows[0].time)
        for row in rows:
            if row.outer is not None and row.margin is not None:
                polygon = polygon_message(stamp, rounded_outward(row.outer, row.margin))
                self.put(f"/{row.robot}/region", POLYGONS, stamp, polygon)
            if row.ekf is not None:
                self.put(f"/{row.robot}/ekf", POSES, stamp, pose_message(stamp, row.ekf))

    def put(self, topic: str, kind: Kind, stamp: int, message: bytes) -> None:
        """Append a message of a kind to a topic, at a time [ns]."""
        with named(self._path):
            if topic not in self._channels:
                name, form, definition, encoding = kind
                if name not in self._schemas:
                    self._schemas[name] = self._file.register_schema(name, form, definition)
                self._channels[topic] = self._file.register_channel(topic, encoding, self._schemas[name])
            self._file.add_message(self._channels[topic], stamp, message, stamp)

    def close(self) -> None:
        """Write the end of the file, with its index."""
        with named(self._path):
            try:
                self._file.finish()
            finally:
                self._stream.close()
