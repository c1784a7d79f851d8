"""The settings that convert each form of the minute, as a newcomer would write them."""

from __future__ import annotations

from pathlib import Path

from experiments.minute.said import Minute
from experiments.show.output import write_whole

TEAM = """# {form} of one minute of two robots. docs/own-data.md explains every line. To convert it:
#   python -m experiments.convert {settings} {data} OUT.jsonl

[team]  # what is known of all
arena = {arena}  # two corners [m]
landmarks = {{ {landmarks} }}  # [m]
speed_limit = {speed_limit}  # [m/s]
turn_rate_limit = {turn_rate_limit}  # [rad/s]
start = 100.0  # when what [robots.NAME] says of the start holds [s]

"""
ROBOT = """[robots.{robot}]
start = {{ box = {box}, heading = {heading}, heading_bound = {heading_bound} }}

"""
OF_BAGS = """[input]
stamp = "header"  # when it was measured, not when it was recorded

"""
OF_TABLES = """[input]
stamp = "stamp"  # the column
stamp_unit = "ns"

"""
STREAMS = """[every_robot]  # {{robot}} stands for its name, {{target}} for whom it measures
odometry = {{ {odometry}, longest = 0.021, {motion} }}
compass = {{ {compass}, bound = {bounds.compass} }}
detections = {{ {detections}, range_bound = {bounds.detection}, bearing_bound = {bounds.bearing} }}
range = {{ {uwb}, bound = [{bounds.uwb[0]}, {bounds.uwb[1]}] }}  # UWB reads long, never short
truth = {{ {truth} }}
"""
PATHS = 'id = "detections[*].id", range = "detections[*].range", bearing = "detections[*].bearing"'
OF_TOPICS = {
    "odometry": 'topic = "/{robot}/odom"',
    "compass": 'topic = "/{robot}/imu"',
    "detections": f'topic = "/{{robot}}/detections", {PATHS}',
    "uwb": 'topic = "/{robot}/uwb/{target}"',
    "truth": 'topic = "/{robot}/truth"',
}
OF_FILES = {
    "odometry": 'file = "{robot}_odometry.csv"',
    "compass": 'file = "{robot}_compass.csv"',
    "detections": 'file = "{robot}_detections.csv"',
    "uwb": 'file = "{robot}_uwb.csv"',
    "truth": 'file = "{robot}_truth.csv", heading = "heading"',
}
FORMS = {"csv": "CSV files", "mcap": "A recording by ROS 2", "bag": "A recording by ROS 1"}


def write_settings(folder: Path, minute: Minute) -> None:
    """Write the settings of all three forms.

    Raises:
        OSError: They cannot be written.
    """
    for form in FORMS:
        write_whole(folder / f"minute_{form}.toml", settings_text(form, minute))


def settings_text(form: str, minute: Minute) -> str:
    """Return the settings of one form: "csv", "mcap" or "bag"."""
    landmarks = ", ".join(f"{name} = {place}" for name, place in minute.landmarks.items())
    text = TEAM.format(
        form=FORMS[form],
        settings=f"minute_{form}.toml",
        data=f"minute.{form}",
        arena=minute.arena,
        landmarks=landmarks,
        speed_limit=minute.speed_limit,
        turn_rate_limit=minute.turn_rate_limit,
    )
    text += OF_TABLES if form == "csv" else OF_BAGS
    for robot, (_, heading) in minute.starts.items():
        text += ROBOT.format(robot=robot, box=minute.box(robot), heading=heading, heading_bound=minute.bounds.start_heading)
    return text + STREAMS.format(**(OF_FILES if form == "csv" else OF_TOPICS), motion=_motion(minute), bounds=minute.bounds)


def _motion(minute: Minute) -> str:
    bounds = minute.bounds
    several = {"distance": bounds.distance, "turn": bounds.turn, "direction": bounds.direction, "slip": bounds.slip}
    return ", ".join(f"{name}_bound = {bound}" for name, bound in several.items())
