"""What Foxglove draws of a step: an outline, a light filling and a name for each robot, as `foxglove.SceneUpdate`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TextPrimitive_pb2 import TextPrimitive
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from experiments.regions.ros import FRAME
from experiments.regions.rows import Points, Row
from experiments.regions.stamps import SECOND
from experiments.show.colours import Colour, colour_of

NAME: str = SceneUpdate.DESCRIPTOR.full_name
SUSPENDED: Colour = (255, 76, 76)  # outlines of what is not guaranteed
FILLING, WIDTH, LETTERS = 0.2, 2.0, 12.0  # opacity; of lines and letters [pixels]
LABEL = 0.1  # how far below its polygon a robot's name stands [m]


def definition() -> bytes:
    """Return what a reader needs to decode the messages: the message's file and all that it imports, each after its own."""
    found: dict[str, Any] = {}

    def add(file: Any) -> None:
        for other in file.dependencies:
            add(other)
        found.setdefault(file.name, file)

    add(SceneUpdate.DESCRIPTOR.file)
    files = FileDescriptorSet()
    for file in found.values():
        file.CopyToProto(files.file.add())
    return bytes(files.SerializeToString(deterministic=True))


def scene_message(stamp: int, rows: Sequence[Row]) -> bytes:
    """Return a scene of all regions of a step, at a time [ns]; its coordinates are those of the regions, unrounded."""
    entities = [_entity(stamp, row, row.outer) for row in rows if row.outer is not None]
    return SceneUpdate(entities=entities).SerializeToString(deterministic=True)


def _entity(stamp: int, row: Row, outer: Points) -> SceneEntity:
    corners, own = [Point3(x=x, y=y) for x, y in outer], colour_of(row.number)
    edge = _colour(own if row.in_force else SUSPENDED)
    line = LinePrimitive(
        type=LinePrimitive.LINE_LOOP, pose=_HERE, thickness=WIDTH, scale_invariant=True, points=corners, color=edge
    )
    fan = [corner for k in range(1, len(outer) - 1) for corner in (0, k, k + 1)]
    fill = TriangleListPrimitive(pose=_HERE, points=corners, color=_colour(own, FILLING), indices=fan)
    entity = SceneEntity(frame_id=FRAME, id=row.robot, lines=[line], triangles=[fill], texts=[_text(row.robot, outer)])
    entity.timestamp.seconds, entity.timestamp.nanos = divmod(stamp, SECOND)
    return entity


def _text(name: str, outer: Points) -> TextPrimitive:
    x, y = sum(x for x, _ in outer) / len(outer), min(y for _, y in outer) - LABEL
    text = TextPrimitive(billboard=True, font_size=LETTERS, scale_invariant=True, color=_colour((255, 255, 255)), text=name)
    text.pose.position.x, text.pose.position.y, text.pose.orientation.w = x, y, 1.0
    return text


def _colour(colour: Colour, opacity: float = 1.0) -> Color:
    red, green, blue = (value / 255 for value in colour)
    return Color(r=red, g=green, b=blue, a=opacity)


def _here() -> Any:
    pose = TextPrimitive().pose
    pose.orientation.w = 1.0
    return pose


_HERE = _here()  # points are in the frame's own coordinates
