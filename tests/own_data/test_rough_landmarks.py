"""Landmarks of which settings know only a set: robots that stand in the log, known to stay, and narrowed as they are seen."""

import json
import math

import numpy as np
import pytest
from helpers.own_data.settings_files import OF_TABLES, of_robots

from experiments.convert import main
from experiments.following.scenarios import from_log
from experiments.following.steps import steps
from experiments.own_data import read_settings
from filter import InvalidInput, SetMembershipFilter

ROUGH = "gate = { position = [1.0, 2.0], bound = 0.2 }"
GATE = np.array([1.15, 1.9])
STREAMS = {
    "range": 'file = "uwb.csv", target = "gate", bound = 0.05, target_sensor = "tag"',
    "compass": 'file = "imu.csv", bound = 0.01',
    "bearing": 'file = "camera.csv", id = "id", ids = { 7 = "gate", 8 = "b" }, bound = 0.01, target_sensor = "tag"',
    "position": 'file = "gps.csv", bound = 0.05',
}


def settings(mark=ROUGH, **streams):
    """Return settings in which every robot has streams."""
    sensors = "sensors = { tag = { position = [0.1, 0.0], position_bound = 0.0 } }\nspeed_limit"
    head = OF_TABLES.replace("gate = [1.0, 2.0]", mark).replace("speed_limit", sensors, 1)
    return of_robots(head, **streams)


@pytest.fixture
def converted(tmp_path):
    """Return the records of a log of a minute: a robot that stands at the origin sees the gate for the first ten seconds."""
    way, away = math.atan2(*GATE[::-1]), math.hypot(*GATE)
    rows = {
        "uwb.csv": ["t,range", *(f"{t},{away!r}" for t in range(10))],
        "imu.csv": ["t,heading", *(f"{t},0.0" for t in range(10))],
        "camera.csv": ["t,id,bearing", *(f"{t},7,{way!r}" for t in range(10)), "9,8,0.0"],
        "gps.csv": ["t,x,y", *(f"{t},0.0,0.0" for t in (*range(10), 60))],
    }
    for name, lines in rows.items():
        (tmp_path / name).write_text("\n".join(lines) + "\n")
    (tmp_path / "my.toml").write_text(settings(**STREAMS))
    assert main([str(tmp_path / "my.toml"), str(tmp_path), str(tmp_path / "out.jsonl")]) == 0
    return tmp_path / "out.jsonl"


def test_it_is_a_robot_that_can_neither_drive_nor_turn(converted):
    header, *records = map(json.loads, converted.read_text().splitlines())
    assert (header["robots"], header["landmarks"]) == (["a", "b", "gate"], {})
    assert header["speed_limit"] == {"a": 1.0, "b": 1.0, "gate": 0.0}
    assert header["turn_rate_limit"] == {"a": 2.0, "b": 2.0, "gate": 0.0}
    corners = [[0.8, 1.8], [1.2, 1.8], [1.2, 2.2], [0.8, 2.2]]
    assert records[2] == {"record": "initial", "robot": "gate", "vertices": corners, "heading": None}


def test_it_is_measured_like_a_robot_but_carries_no_tag(converted):
    seen = [
        record for record in map(json.loads, converted.read_text().splitlines()) if record["record"] in ("range", "bearing")
    ]
    assert {(record["target"], record.get("target_sensor")) for record in seen} == {("gate", None), ("b", "tag")}


def test_it_is_narrowed_and_stays_for_the_minute(converted):
    scenario = from_log(converted)
    regions = [step.belief.regions[2].outer for step in steps(SetMembershipFilter(scenario.team), scenario)]
    assert all(region.contains(GATE) for region in regions)
    assert regions[9].area < 0.5 * 0.16
    assert regions[-1].area <= regions[9].area * (1 + 1e-6)


@pytest.mark.parametrize(
    ("mark", "told"),
    [
        ("gate = {}", "landmarks gate: a table with box, vertices, or position and bound; came none of these"),
        ("gate = { position = [1.0, 2.0] }", 'landmarks gate: a key "bound"'),
        ("gate = { position = [1.0, 2.0], within = 0.2 }", 'a key "bound"'),
        ("gate = { position = [1.0, 2.0], bound = -0.2 }", "a bound in x and y"),
        ("gate = { box = [[0, 0], [1, 1]], heading = 0.0 }", "keys that are known"),
        ("gate = [1.0]", "gate: [x, y], or a table with box, vertices, or position and bound"),
        ("a = { position = [1.0, 2.0], bound = 0.2 }", '"a" for both'),
    ],
)
def test_a_slip_is_told(tmp_path, mark, told):
    (tmp_path / "my.toml").write_text(settings(mark, compass=STREAMS["compass"]))
    with pytest.raises(InvalidInput) as caught:
        read_settings(tmp_path / "my.toml")
    assert told in str(caught.value)


def test_ids_may_name_it_and_a_polygon_will_do(tmp_path):
    text = settings("gate = { vertices = [[0, 0], [1, 0], [0, 1]] }", compass=STREAMS["compass"])
    (tmp_path / "my.toml").write_text(text.replace("speed_limit", "ids = { 17 = 'gate' }\nspeed_limit", 1))
    facts = read_settings(tmp_path / "my.toml").facts
    assert facts.body("17", {}) == {"target": "gate"}
    assert facts.robots["gate"].vertices == [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
