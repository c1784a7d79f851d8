"""Messages of ROS 2 as bytes, without ROS: their definitions, and CDR, little-endian."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from math import cos, sin

from experiments.regions.rows import Estimate
from experiments.regions.stamps import SECOND

FRAME = "map"  # whose coordinates these are, see REP 105
ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little-endian
AGAIN = "=" * 80 + "\nMSG: "
HEADER = AGAIN + "std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
TIME = AGAIN + "builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"

POLYGON = "geometry_msgs/msg/PolygonStamped"
POLYGON_DEFINITION = (
    "std_msgs/Header header\ngeometry_msgs/Polygon polygon\n"
    + HEADER
    + TIME
    + f"{AGAIN}geometry_msgs/Polygon\ngeometry_msgs/Point32[] points\n"
    + f"{AGAIN}geometry_msgs/Point32\nfloat32 x\nfloat32 y\nfloat32 z\n"
)
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
POSE_DEFINITION = (
    "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n"
    + HEADER
    + TIME
    + f"{AGAIN}geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n"
    + f"{AGAIN}geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
    + f"{AGAIN}geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    + f"{AGAIN}geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
)
PLANAR = (0, 1, 5)  # x, y and yaw among x, y, z, roll, pitch, yaw


def polygon_message(stamp: int, corners: Sequence[tuple[float, float]]) -> bytes:
    """Return a `PolygonStamped` of corners that are float32 [m], at a time [ns]."""
    flat = [value for x, y in corners for value in (x, y, 0.0)]
    return _header(stamp) + struct.pack(f"<I{len(flat)}f", len(corners), *flat)


def pose_message(stamp: int, estimate: Estimate) -> bytes:
    """Return a `PoseWithCovarianceStamped` of an estimate in the plane, at a time [ns]."""
    x, y, half = *estimate.position, estimate.heading / 2
    covariance = [0.0] * 36
    for i, row in zip(PLANAR, estimate.covariance, strict=True):
        for j, value in zip(PLANAR, row, strict=True):
            covariance[6 * i + j] = value
    return _header(stamp) + struct.pack("<43d", x, y, 0.0, 0.0, 0.0, sin(half), cos(half), *covariance)


def _header(stamp: int) -> bytes:
    """Return encapsulation and header: with this frame 16 bytes, so that nothing that follows has to be padded."""
    return ENCAPSULATION + struct.pack("<iII4s", *divmod(stamp, SECOND), len(FRAME) + 1, FRAME.encode())
