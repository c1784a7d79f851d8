"""Regions as an MCAP file for Foxglove: what ROS has of them, and a scene."""

from __future__ import annotations

from collections.abc import Sequence

from mcap.well_known import MessageEncoding, SchemaEncoding

from experiments.regions import as_ros2
from experiments.regions.as_ros2 import Kind
from experiments.regions.rows import Row
from experiments.regions.scene import NAME, definition, scene_message
from experiments.regions.stamps import nanoseconds

SCENES: Kind = (NAME, SchemaEncoding.Protobuf, definition(), MessageEncoding.Protobuf)


class Writer(as_ros2.Writer):
    """Writes `regions.mcap`: the topics of `regions_ros2.mcap`, and `/regions`, the scene."""

    profile = ""  # which says that it holds messages of more than one kind

    def write(self, rows: Sequence[Row]) -> None:
        """Append a step."""
        super().write(rows)
        if any(row.outer is not None for row in rows):
            stamp = nanoseconds(rows[0].time)
            self.put("/regions", SCENES, stamp, scene_message(stamp, rows))
