"""Real bags of other people become logs: standing and driving robots with UWB ranges, of ROS 1 and of ROS 2.

They are those of TIERS/uwb-cooperative-mrs-localization and of TIERS' work on relative localization; TIERS_BAGS names the
folder that has them as case_2, case_4 and shortbag.
"""

import json
from collections import Counter
from pathlib import Path

import pytest
from helpers.own_data.tiers import BAGS, STANDING, needs_bags

from experiments.convert import main

pytestmark = needs_bags
CARRIED = """
[team]
arena = [[-3.0, -3.0], [9.0, 9.0]]
landmarks = { 1 = [2.69, 2.40], 2 = [3.75, 2.39], 3 = [3.77, 3.29], 4 = [2.70, 3.29] }
speed_limit = 3.0
turn_rate_limit = 3.0
[input]
stamp = "header"
types = "humble"
[robots.5]
truth = { topic = "/vrpn_client_node/uwb_01/pose" }
[robots.6]
truth = { topic = "/vrpn_client_node/uwb_02/pose" }
[every_robot]
range = [
  { topic = "/uwb/tof/n_{robot}/n_{target}/distance", bound = [0.0, 1.0] },
  { topic = "/uwb/tof/n_{target}/n_{robot}/distance", bound = [0.0, 1.0] },
]
"""
MOTION = "longest = 0.2, distance_bound = 0.02, turn_bound = 0.1, direction_bound = 0.3, slip_bound = 0.005"
# The fifth robot's odometry was never stamped, and the bag was recorded 48 days after its messages.
DRIVING = f"""
[team]
arena = [[-2.0, -2.0], [9.0, 9.0]]
speed_limit = 0.5
turn_rate_limit = 2.0
ids = {{ 3 = "03", 4 = "04", 5 = "05", 7 = "01" }}
[input]
stamp = "header"
types = "galactic"
[robots.01]
[robots.03]
[robots.04]
[robots.05]
odometry = {{ topic = "/cali/turtle05/odom", stamp = "received", clock_offset = -4160411.02, {MOTION} }}
[every_robot]
odometry = {{ topic = "/cali/turtle{{robot}}/odom", {MOTION} }}
range = {{ topic = "/uwb/tof/n_{{robot}}/n_{{target}}/distance", bound = [0.0, 1.2] }}
truth = {{ topic = "/vrpn_client_node/turtlebot{{robot}}_cap/pose" }}
"""
DRIVING = DRIVING.replace("[robots.01]", '[robots.01]\ntruth = { topic = "/vrpn_client_node/turtlebot1_cap/pose" }')
for name in ("03", "04", "05"):
    own = f'[robots.{name}]\ntruth = {{ topic = "/vrpn_client_node/turtlebot{name[1]}_cap/pose" }}'
    DRIVING = DRIVING.replace(f"[robots.{name}]", own)


@pytest.fixture
def converted(tmp_path, capsys):
    """Return a function that converts a bag; it returns the log's text, its records, and what was told."""

    def converted(bag, settings):
        (tmp_path / "my.toml").write_text(settings)
        out = tmp_path / "out.jsonl"
        assert main([str(tmp_path / "my.toml"), str(Path(str(BAGS)) / bag), str(out)]) == 0
        text = out.read_text()
        return text, [json.loads(line) for line in text.splitlines()], capsys.readouterr().err

    return converted


def counts(records):
    return Counter(record["record"] for record in records)


def test_seven_robots_that_stand(converted):
    text, records, told = converted("case_4/test1.bag", STANDING)
    assert counts(records) == {"header": 1, "initial": 7, "range": 12005, "truth": 7195}
    pairs = {(record["robot"], record["target"]) for record in records if record["record"] == "range"}
    assert len(pairs) == 42
    assert len(told.splitlines()) == 14
    assert all("n_8" in line for line in told.splitlines())
    assert converted("case_4/ros2/test1", STANDING)[0] == text


def test_two_tags_that_are_carried_over_four_platforms(converted):
    bag = "over_parallel_2023-03-24-18-17-29"
    text, records, told = converted(f"case_2/{bag}.bag", CARRIED)
    assert counts(records) == {"header": 1, "initial": 2, "range": 9906, "truth": 1009}
    assert {record["landmark"] for record in records if record["record"] == "range"} == {"1", "2", "3", "4"}
    assert "left out: /tf, tf2_msgs/msg/TFMessage, 1008 messages: transforms that move are not read" in told
    twin, _, told = converted(f"case_2/ros2/{bag}", CARRIED)
    assert twin == text
    assert "left out: /rosout, rosgraph_msgs/msg/Log, 27 messages: the definition of its type is missing" in told


def test_four_robots_that_drive(converted):
    _, records, told = converted("shortbag", DRIVING)
    found = counts(records)
    assert (found["odometry"], found["truth"]) == (1188, 4122)
    pairs = {(record["robot"], record["target"]) for record in records if record["record"] == "range"}
    assert pairs == {("03", "01"), ("03", "04"), ("03", "05"), ("04", "01"), ("04", "05"), ("01", "05")}
    assert sum("depthai_ros_msgs/msg/SpatialDetectionArray" in line for line in told.splitlines()) == 4


def test_a_stamp_that_was_never_filled_in_is_told(tmp_path, capsys):
    (tmp_path / "my.toml").write_text(DRIVING.replace('stamp = "received", clock_offset = -4160411.02, ', ""))
    assert main([str(tmp_path / "my.toml"), str(Path(str(BAGS)) / "shortbag"), str(tmp_path / "out.jsonl")]) == 2
    assert "/cali/turtle05/odom, message 1: a stamp that was filled in" in capsys.readouterr().err
