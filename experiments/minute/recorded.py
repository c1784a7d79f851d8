"""The minute as bags: of ROS 1, and an .mcap file as rosbag2 writes it, by the writers of rosbags.

Cameras see with `corral_msgs/Detections`, a type of our own: no standard message holds an id, a range and a bearing (arrays of
vision_msgs have boxes, radar returns have no id). Its definition is in the bags, as a recorder would have written it.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from experiments.minute.said import Distance, Minute, North, PoseSaid, Said, Seen, Yaw
from experiments.own_data.units import SECOND
from filter import InvalidInput

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

DETECTIONS = "corral_msgs/msg/Detections"
DEFINITION = """std_msgs/Header header
Detection[] detections
================================================================================
MSG: corral_msgs/Detection
string id
float64 range
float64 bearing
"""
TYPES = {
    "odometry": "nav_msgs/msg/Odometry",
    "compass": "sensor_msgs/msg/Imu",
    "detections": DETECTIONS,
    "uwb": "sensor_msgs/msg/Range",
    "truth": "geometry_msgs/msg/PoseStamped",
}
TOPICS = {"odometry": "odom", "compass": "imu", "detections": "detections", "uwb": "uwb", "truth": "truth"}
VERSION: Final = 8  # of rosbag2's metadata, which Iron and all later ones read
NOT_MEASURED = -1.0  # at the head of an Imu's covariance
GREATEST_RANGE = 30.0  # [m]


def write_bag(path: Path, minute: Minute) -> None:
    """Write a bag of ROS 1.

    Raises:
        InvalidInput: The package that writes it is not there.
        OSError: It cannot be written.
    """
    store = _typestore("ros1_noetic")
    from rosbags.rosbag1 import Writer  # noqa: PLC0415 - an optional package

    path.unlink(missing_ok=True)
    with Writer(path) as writer:
        _write(writer, store, minute, store.serialize_ros1)


def write_mcap(path: Path, minute: Minute) -> None:
    """Write an .mcap file as rosbag2 does.

    Raises:
        InvalidInput: The package that writes it is not there.
        OSError: It cannot be written.
    """
    store = _typestore("ros2_humble")
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415 - an optional package

    with tempfile.TemporaryDirectory(dir=path.parent) as folder:  # it makes a folder, with metadata beside the file
        bag = Path(folder) / path.stem
        with Writer(bag, version=VERSION, storage_plugin=StoragePlugin.MCAP) as writer:
            _write(writer, store, minute, store.serialize_cdr)
        (bag / path.name).replace(path)


def _typestore(name: str) -> Typestore:
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415 - an optional package
    except ImportError:
        raise InvalidInput("rosbags, to write bags: pip install 'corral[data]'", "no such package") from None
    store = get_typestore(Stores(name))
    store.register(get_types_from_msg(DEFINITION, DETECTIONS))
    return store


def _write(writer: Any, store: Typestore, minute: Minute, serialize: Any) -> None:
    messages, connections = _Messages(store), dict[str, Any]()
    for topic, said in sorted(((topic_of(each), each) for each in minute.said), key=lambda pair: pair[0]):
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, TYPES[said.stream], typestore=store)
    for each in minute.said:
        writer.write(connections[topic_of(each)], each.received, serialize(messages.of(each), TYPES[each.stream]))


def topic_of(said: Said) -> str:
    """Return the topic of a message: /alice/odom, /alice/uwb/bob."""
    topic = f"/{said.robot}/{TOPICS[said.stream]}"
    return f"{topic}/{said.value.target}" if isinstance(said.value, Distance) else topic


class _Messages:
    """Makes messages of the types of a store."""

    def __init__(self, store: Typestore) -> None:
        self._types: dict[str, Any] = dict(store.types)
        self._sequence = {"seq": 0} if "seq" in dict(store.fielddefs["std_msgs/msg/Header"][1]) else {}

    def of(self, said: Said) -> Any:
        """Return the message that says it."""
        frame = "world" if said.stream == "truth" else f"{said.robot}/{'odom' if said.stream == 'odometry' else 'base_link'}"
        return self._new(TYPES[said.stream], header=self._header(said.stamp, frame), **self._fields(said))

    def _fields(self, said: Said) -> dict[str, Any]:
        match said.value:
            case PoseSaid() as pose:
                return self._odometry(said.robot, pose) if said.stream == "odometry" else {"pose": self._pose(pose)}
            case North(turned):
                return self._imu(turned)
            case Seen(targets):
                return {"detections": [self._detection(name, *each) for name, each in targets.items()]}
            case Distance(_, distance):
                limits = {"field_of_view": 0.0, "min_range": 0.0, "max_range": GREATEST_RANGE}
                return {"radiation_type": 0, **limits, "range": distance}

    def _new(self, kind: str, **fields: Any) -> Any:
        return self._types[kind](**fields)

    def _header(self, stamp: int, frame: str) -> Any:
        time = self._new("builtin_interfaces/msg/Time", sec=stamp // SECOND, nanosec=stamp % SECOND)
        return self._new("std_msgs/msg/Header", stamp=time, frame_id=frame, **self._sequence)

    def _quaternion(self, turned: Yaw) -> Any:
        return self._new("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=turned.z, w=turned.w)

    def _vector(self, x: float = 0.0, z: float = 0.0) -> Any:
        return self._new("geometry_msgs/msg/Vector3", x=x, y=0.0, z=z)

    def _pose(self, pose: PoseSaid) -> Any:
        place = self._new("geometry_msgs/msg/Point", x=pose.x, y=pose.y, z=0.0)
        return self._new("geometry_msgs/msg/Pose", position=place, orientation=self._quaternion(pose.turned))

    def _odometry(self, robot: str, pose: PoseSaid) -> dict[str, Any]:
        twist = self._new("geometry_msgs/msg/Twist", linear=self._vector(x=pose.speed), angular=self._vector(z=pose.turn_rate))
        return {
            "child_frame_id": f"{robot}/base_link",
            "pose": self._new("geometry_msgs/msg/PoseWithCovariance", pose=self._pose(pose), covariance=np.zeros(36)),
            "twist": self._new("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
        }

    def _imu(self, turned: Yaw) -> dict[str, Any]:
        nothing = np.array([NOT_MEASURED, *np.zeros(8)])
        return {
            "orientation": self._quaternion(turned),
            "orientation_covariance": np.zeros(9),
            "angular_velocity": self._vector(),
            "angular_velocity_covariance": nothing,
            "linear_acceleration": self._vector(),
            "linear_acceleration_covariance": nothing,
        }

    def _detection(self, name: str, distance: float, bearing: float) -> Any:
        return self._new("corral_msgs/msg/Detection", id=name, range=distance, bearing=bearing)
