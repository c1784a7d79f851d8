"""What a stream can hold: for each kind its bounds, its other keys, and the fields that it is read from.

A field is where in a message, or in which column, a value is. Messages that are usual have theirs known (`MESSAGES`), and a
column is looked for under the field's own name (`COLUMNS`); what the settings say goes before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

ANGLE, LENGTH, PLAIN = "angle", "length", "plain"


@dataclass(frozen=True)
class StreamKind:
    """What the settings can say of a stream of one kind.

    Attributes:
        fields: Names of the fields that can be read.
        needs: What has to be there to make records: one of these sets of fields.
        bounds: Names of the bounds, each with what it is a bound of; all have to be declared but for relative ones.
        variances: For each bound that a message's covariance can give, the fields that hold the variances.
        pairs: Whether a bound may be a pair, [low, high] of measured - true.
        conventions: Whether there is anything to turn or mirror.
        only_with: Of bounds that have to be declared only where some field is read: that field.
    """

    fields: tuple[str, ...]
    needs: tuple[tuple[str, ...], ...]
    bounds: Mapping[str, str]
    variances: Mapping[str, tuple[str, ...]]
    pairs: bool = False
    conventions: bool = True
    only_with: Mapping[str, str] = field(default_factory=dict)


ENDS = ("first", "second")  # fields that name the two landmarks of a difference
POSE = ("x", "y", "heading"), ("x", "y", "orientation")
STREAM_KINDS: dict[str, StreamKind] = {
    "odometry": StreamKind(
        ("x", "y", "heading", "orientation", "distance", "turn"),
        (("distance", "turn"), *POSE),
        {"distance_bound": LENGTH, "turn_bound": ANGLE, "direction_bound": ANGLE, "slip_bound": LENGTH}
        | {"distance_relative_bound": PLAIN, "turn_relative_bound": PLAIN},
        {},
    ),
    "twist": StreamKind(
        ("speed", "speed_aside", "turn_rate", "speed_variance", "turn_rate_variance"),
        (("speed", "turn_rate"),),
        {"speed_bound": LENGTH, "turn_rate_bound": ANGLE, "direction_bound": ANGLE, "slip_rate": LENGTH},
        {"speed_bound": ("speed_variance",), "turn_rate_bound": ("turn_rate_variance",)},
    ),
    "compass": StreamKind(
        ("heading", "orientation", "variance"),
        (("heading",), ("orientation",)),
        {"bound": ANGLE},
        {"bound": ("variance",)},
        pairs=True,
    ),
    "range": StreamKind(
        ("range", "id", "least", "greatest", "variance"),
        (("range",),),
        {"bound": LENGTH, "relative_bound": PLAIN},
        {"bound": ("variance",)},
        pairs=True,
        conventions=False,
    ),
    "bearing": StreamKind(
        ("bearing", "id", "variance"), (("bearing",),), {"bound": ANGLE}, {"bound": ("variance",)}, pairs=True
    ),
    "detections": StreamKind(
        ("range", "bearing", "x", "y", "heading", "id"),
        (("range", "bearing"), ("x", "y")),
        {"range_bound": LENGTH, "range_relative_bound": PLAIN, "bearing_bound": ANGLE}
        | {"position_bound": LENGTH, "heading_bound": ANGLE},
        {},
        pairs=True,
        only_with={"range_bound": "range", "range_relative_bound": "range", "bearing_bound": "bearing"}
        | {"position_bound": "x", "heading_bound": "heading"},
    ),
    "range_difference": StreamKind(
        ("difference", "first", "second"), (("difference",),), {"bound": LENGTH}, {}, pairs=True, conventions=False
    ),
    "position": StreamKind(
        ("x", "y", "latitude", "longitude", "status", "variance_x", "variance_y"),
        (("latitude", "longitude"), ("x", "y")),
        {"bound": LENGTH},
        {"bound": ("variance_x", "variance_y")},
    ),
    "truth": StreamKind(("x", "y", "heading", "orientation"), (*POSE, ("x", "y")), {}, {}),
}
# Two ways to say the same: whoever says the one in the settings does not mean the other one, that is known of the message.
RIVALS: dict[str, tuple[str, ...]] = {
    "heading": ("orientation",),
    "orientation": ("heading",),
    "distance": ("x", "y", "heading", "orientation"),
    "latitude": ("x", "y"),
    "x": ("latitude", "longitude", "status", "range", "bearing"),
}
COLUMNS: dict[str, tuple[str, ...]] = {
    "odometry": ("x", "y", "heading"),
    "twist": ("speed", "turn_rate"),
    "compass": ("heading",),
    "range": ("range",),
    "bearing": ("bearing",),
    "detections": ("range", "bearing"),
    "range_difference": ("difference",),
    "position": ("x", "y"),
    "truth": ("x", "y"),
}


def _pose(prefix: str) -> dict[str, str]:
    place = {"x": f"{prefix}position.x", "y": f"{prefix}position.y"}
    return place | {"orientation": f"{prefix}orientation"}


def _twist(prefix: str) -> dict[str, str]:
    linear = {"speed": f"{prefix}linear.x", "speed_aside": f"{prefix}linear.y"}
    return linear | {"turn_rate": f"{prefix}angular.z"}


_TWIST_VARIANCES = {"speed_variance": "twist.covariance[0]", "turn_rate_variance": "twist.covariance[35]"}
_PLACE_VARIANCES = {"variance_x": "pose.covariance[0]", "variance_y": "pose.covariance[7]"}
_PLAIN_POSE, _DEEP_POSE, _POINT = _pose("pose."), _pose("pose.pose."), {"x": "point.x", "y": "point.y"}


def _without_heading(fields: Mapping[str, str]) -> dict[str, str]:
    return {name: path for name, path in fields.items() if name != "orientation"}


MESSAGES: dict[str, dict[str, dict[str, str]]] = {
    "odometry": {"nav_msgs/msg/Odometry": _DEEP_POSE},
    "twist": {
        "geometry_msgs/msg/Twist": _twist(""),
        "geometry_msgs/msg/TwistStamped": _twist("twist."),
        "geometry_msgs/msg/TwistWithCovarianceStamped": _twist("twist.twist.") | _TWIST_VARIANCES,
        "nav_msgs/msg/Odometry": _twist("twist.twist.") | _TWIST_VARIANCES,
    },
    "compass": {
        "sensor_msgs/msg/Imu": {"orientation": "orientation", "variance": "orientation_covariance[8]"},
        "geometry_msgs/msg/PoseStamped": {"orientation": "pose.orientation"},
        "geometry_msgs/msg/PoseWithCovarianceStamped": {
            "orientation": "pose.pose.orientation",
            "variance": "pose.covariance[35]",
        },
    },
    "range": {"sensor_msgs/msg/Range": {"range": "range", "least": "min_range", "greatest": "max_range"}},
    "bearing": {},
    "detections": {},
    "range_difference": {},
    "position": {
        "geometry_msgs/msg/PoseStamped": _without_heading(_PLAIN_POSE),
        "geometry_msgs/msg/PoseWithCovarianceStamped": _without_heading(_DEEP_POSE) | _PLACE_VARIANCES,
        "geometry_msgs/msg/PointStamped": _POINT,
        "sensor_msgs/msg/NavSatFix": {
            "latitude": "latitude",
            "longitude": "longitude",
            "status": "status.status",
            "variance_x": "position_covariance[0]",
            "variance_y": "position_covariance[4]",
        },
    },
    "truth": {
        "geometry_msgs/msg/PoseStamped": _PLAIN_POSE,
        "geometry_msgs/msg/PoseWithCovarianceStamped": _DEEP_POSE,
        "geometry_msgs/msg/PointStamped": _POINT,
        "nav_msgs/msg/Odometry": _DEEP_POSE,
    },
}


def fields_of(kind: str, known: Mapping[str, str], said: Mapping[str, str]) -> dict[str, str]:
    """Return the fields to read: those known of a message or a file, with what the settings say instead."""
    dropped = {rival for name in said for rival in RIVALS.get(name, ())}
    fields = {name: path for name, path in known.items() if name not in dropped} | dict(said)
    return {name: fields[name] for name in STREAM_KINDS[kind].fields if name in fields}


def is_enough(kind: str, fields: Mapping[str, str]) -> bool:
    """Return whether there is a set of fields that records of the kind can be made from."""
    return any(set(needs) <= set(fields) for needs in STREAM_KINDS[kind].needs)
