"""CSV files as people have them, and those that nobody should have."""

import gzip
import json
import math
import re
from pathlib import Path

import pytest
from helpers.own_data.settings_files import OF_TABLES, of_robots

from experiments.convert import main
from experiments.logs import LogReader
from experiments.show.command import BAD_INPUT

COMPASS = 'file = "imu.csv", bound = 0.1'
GOOD = "t,heading\n0.5,1.0\n1.0,1.1\n"


@pytest.fixture
def converted(tmp_path, capsys):
    """Return a function that converts files; it returns exit code, records after the initial ones, and what was told."""

    def converted(files, settings=None, at=""):
        (tmp_path / "data").mkdir(exist_ok=True)
        for name, content in files.items():
            (tmp_path / "data" / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        (tmp_path / "my.toml").write_text(settings or of_robots(OF_TABLES, compass=COMPASS))
        code = main([str(tmp_path / "my.toml"), str(tmp_path / "data" / at), str(tmp_path / "out.jsonl")])
        out = tmp_path / "out.jsonl"
        records = [json.loads(line) for line in out.read_text().splitlines()][3:] if out.exists() else []
        assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []
        return code, records, capsys.readouterr().err

    return converted


EXPECTED = [
    {"record": "compass", "time": 0.5, "robot": "a", "heading": 1.0, "bound": 0.1},
    {"record": "compass", "time": 1.0, "robot": "a", "heading": 1.1, "bound": 0.1},
]


@pytest.mark.parametrize(
    "content",
    [
        GOOD,
        b"\xef\xbb\xbf" + GOOD.encode(),
        gzip.compress(GOOD.encode()),
        GOOD.replace("\n", "\r\n"),
        GOOD.rstrip("\n"),
        GOOD.replace("1.0,1.1", "\n1.0,1.1\n"),
        GOOD.replace(",", ";"),
        GOOD.replace(",", "\t"),
        'note,"t",heading\n"a, b",0.5,1.0\n,1.0,1.1\n',
        "t , heading\n 0.5, 1.0\n1.0,1.1\n",
    ],
    ids=["plain", "mark", "gzip", "windows", "no end", "blank lines", "semicolons", "tabs", "quoted", "blanks"],
)
def test_a_table_is_read_however_it_is_written(converted, content):
    assert converted({"imu.csv": content})[:2] == (0, EXPECTED)


def test_a_single_file_is_read_alone(converted):
    assert converted({"imu.csv": GOOD}, at="imu.csv")[:2] == (0, EXPECTED)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("", "a header line"),
        ("\n\n", "a header line"),
        (GOOD.replace("heading", "heding"), 'a column of its header line: did you mean "heding"?'),
        (GOOD + "1.5\n", "imu.csv, line 4: 2 columns"),
        ("t,heading,heading\n1,1,1\n", 'several called "heading"'),
        (GOOD + "1.5,1,2\n", "imu.csv, line 4: 2 columns"),
        (GOOD + "1.5,abc\n", "imu.csv, line 4: heading: a number"),
        (GOOD + '1.5,"0,5"\n', "imu.csv, line 4: heading: a number"),
        (GOOD + "noon,1\n", "imu.csv, line 4: a stamp [s]"),
        (GOOD + "1.5,57\n", 'imu.csv, line 4: angles in radians; declare unit = "degrees"'),
        (GOOD.encode("utf-16"), "UTF-16"),
        (GOOD.encode() + b"\xff\xfe,1\n", "UTF-8"),
        (gzip.compress(GOOD.encode(), mtime=0)[:-6], "cut off or damaged"),
        ("t,heading\n", "data that records can be made of"),
        ("t,heading\n0.5,\n0.6,nan\n", "data that records can be made of"),
    ],
)
def test_a_table_that_is_none_is_told_and_no_log_is_there(converted, content, told):
    code, records, said = converted({"imu.csv": content})
    assert (code, records) == (BAD_INPUT, [])
    assert told in said


def test_what_was_not_measured_is_left_out_and_counted(converted):
    code, records, said = converted({"imu.csv": GOOD + "1.5,\n2.0,nan\n2.5,inf\n", "notes.csv": "a\n1\n2\n"})
    assert (code, records) == (0, EXPECTED)
    assert "left out: imu.csv, CSV, 1 of 5 messages: nothing in heading" in said
    assert "left out: imu.csv, CSV, 2 of 5 messages: heading is not a finite number" in said
    assert "left out: notes.csv, CSV, 2 messages: the settings do not name it" in said


def test_a_file_that_is_not_there_is_told_with_the_nearest(converted):
    code, _, said = converted({"imus.csv": GOOD})
    assert code == BAD_INPUT
    assert 'did you mean "imus.csv"?' in said


@pytest.mark.parametrize("content", [{}, {"a.txt": "x"}])
def test_a_folder_without_tables_is_told(converted, content):
    code, _, said = converted(content)
    assert code == BAD_INPUT
    assert "*.csv" in said


def test_streams_may_share_one_wide_table(converted):
    streams = {
        "compass": 'file = "all.csv", bound = 1, unit = "degrees"',
        "range": 'file = "all.csv", range = "to_gate", target = "gate", bound = 1, unit = "centimetres"',
    }
    code, records, said = converted({"all.csv": "t,heading,to_gate\n1,90,\n2,,150\n"}, of_robots(OF_TABLES, **streams))
    assert code == 0, said
    assert [record["record"] for record in records] == ["compass", "range"]
    assert records[1] == {
        "record": "range",
        "time": 2.0,
        "robot": "a",
        "landmark": "gate",
        "range": 1.5,
        "bound": 0.01,
        "relative_bound": 0.0,
    }


def test_a_long_table_is_sorted_out_by_what_columns_hold(converted):
    text = f"{OF_TABLES}\n[robots.a]\n[robots.b]\n[every_robot]\n"
    files = {"all.csv": "t,who,what,id,range,bearing\n1,a,camera,b,2.0,0.5\n1,b,camera,gate,3.0,-0.5\n2,a,other,b,9,9\n"}
    for robot in "ab":
        only = f'only = {{ who = "{robot}", what = "camera" }}'
        stream = f'{{ file = "all.csv", {only}, range_bound = 0.1, bearing_bound = 0.1 }}'
        text = text.replace(f"[robots.{robot}]", f"[robots.{robot}]\ndetections = {stream}")
    code, records, said = converted(files, text)
    assert code == 0, said
    assert [(r["record"], r["robot"], r.get("target"), r.get("landmark")) for r in records] == [
        ("bearing", "a", "b", None),
        ("range", "a", "b", None),
        ("bearing", "b", None, "gate"),
        ("range", "b", None, "gate"),
    ]


def test_files_of_pairs_are_found_by_their_names(converted):
    files = {"a_b.csv": "t,range\n1,2.0\n", "a_gate.csv": "t,range\n2,3.0\n", "a_ghost.csv": "t,range\n1,2.0\n"}
    code, records, said = converted(files, of_robots(OF_TABLES, range='file = "{robot}_{target}.csv", bound = 0.1'))
    assert code == 0, said
    assert [record.get("target", record.get("landmark")) for record in records] == ["b", "gate"]
    assert 'a_ghost.csv, CSV, 1 messages: no robot or landmark is called "ghost"' in said


def test_a_quaternion_may_be_four_columns_or_the_head_of_their_names(converted):
    for header, said in (("qx,qy,qz,qw", "qx qy qz qw"), ("q.x,q.y,q.z,q.w", "q")):
        files = {"imu.csv": f"t,{header}\n1,0,0,0.7071067811865476,0.7071067811865476\n"}
        code, records, told = converted(files, of_robots(OF_TABLES, compass=f'{COMPASS}, orientation = "{said}"'))
        assert code == 0, told
        assert records[0]["heading"] == pytest.approx(1.5707963267948966)


@pytest.mark.parametrize(
    ("stream", "told"),
    [
        ({"compass": 'topic = "imu.csv", bound = 0.1'}, '"file", as the input is CSV files'),
        ({"compass": COMPASS + ', stamp = "header"'}, "a column of its header line"),
        ({"compass": COMPASS + ', variance = "t"'}, '"k_sigma" to go with "variance"'),
        ({"range": 'file = "imu.csv", range = "heading", bound = 0.1'}, "a column of its header line"),
        ({"range": 'file = "imu.csv", range = "heading", target = "gat", bound = 0.1'}, "target: the name of"),
        ({"range": 'file = "imu.csv", range = "heading", target = "a", bound = 0.1'}, "another one than the robot itself"),
        ({"range": 'file = "imu.csv", range = "heading", ids = { 7 = "gat" }, bound = 0.1'}, 'did you mean "gate"'),
        ({"range": 'file = "imu.csv", range = "heading", target = "b", id = "t", bound = 0.1'}, "who is measured, said once"),
    ],
)
def test_settings_that_do_not_fit_the_tables_are_told(converted, stream, told):
    code, _, said = converted({"imu.csv": GOOD}, of_robots(OF_TABLES, **stream))
    assert code == BAD_INPUT
    assert told in said


def test_the_example_for_newcomers_works(converted):
    """Robots that call one another by numbers, with a compass in degrees from north that needs correcting."""
    page = (Path(__file__).parents[2] / "docs/own-data.md").read_text()
    settings = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)[0]
    files = {}
    for robot, other in (("alice", 4), ("bob", 3)):
        files[f"{robot}_odom.csv"] = "time,x,y,heading\n1.0,0,0,0\n1.1,0.05,0,0\n"
        files[f"{robot}_compass.csv"] = "time,degrees\n1.05,85.8\n"
        files[f"{robot}_uwb.csv"] = f"time,node,mm\n1.06,17,2500\n1.07,{other},1500\n"
    code, records, said = converted(files, settings)
    assert (code, said) == (0, "")
    by_kind = {kind: [r for r in records if r["record"] == kind] for kind in ("odometry", "compass", "range")}
    assert [record["distance"] for record in by_kind["odometry"]] == [0.05, 0.05]
    assert [record["heading"] for record in by_kind["compass"]] == pytest.approx([0.0, 0.0])
    assert by_kind["compass"][0]["bound"] == pytest.approx(0.0872664626)
    ranges = [(r["robot"], r.get("target"), r.get("landmark"), r["range"], r["bound"]) for r in by_kind["range"]]
    assert ranges == [
        ("alice", None, "gate", 2.5, [0.0, 0.3]),
        ("bob", None, "gate", 2.5, [0.0, 0.3]),
        ("alice", "bob", None, 1.5, [0.0, 0.3]),
        ("bob", "alice", None, 1.5, [0.0, 0.3]),
    ]


def test_what_mounted_sensors_measure_is_said_to_be_theirs(converted, tmp_path):
    camera, tag = (
        "position = [0.2, -0.1], position_bound = 0.01",
        "angle = 90, angle_bound = 1, unit = 'degrees', time_bound = 0.05",
    )
    sensors = f"sensors = {{ camera = {{ {camera} }}, tag = {{ {tag} }} }}"
    head = OF_TABLES.replace("speed_limit", f"{sensors}\nspeed_limit", 1)
    seen = 'file = "seen.csv", id = "id", bound = 0.1, sensor = "camera", target_sensor = "tag"'
    way, gps = 'file = "way.csv", bound = 0.1, sensor = "tag"', 'file = "gps.csv", bound = 0.1, sensor = "camera"'
    settings = of_robots(head, range=seen, compass=way, position=gps)
    seen, way, gps = "t,range,id\n1,2.5,b\n2,3.5,gate\n", "t,heading\n1,0.5\n", "t,x,y\n3,1,2\n"
    files = {"seen.csv": seen, "way.csv": way, "gps.csv": gps}
    code, records, _ = converted(files, settings)
    assert code == 0
    said = [{name: record.get(name) for name in ("record", "sensor", "target_sensor")} for record in records]
    assert said == [
        {"record": "compass", "sensor": "tag", "target_sensor": None},
        {"record": "range", "sensor": "camera", "target_sensor": "tag"},
        {"record": "range", "sensor": "camera", "target_sensor": None},
        {"record": "position", "sensor": "camera", "target_sensor": None},
    ]
    camera, tag = LogReader(tmp_path / "out.jsonl").header.team.sensors
    assert (camera.name, camera.position.tolist(), camera.position_bound, camera.angle) == ("camera", [0.2, -0.1], 0.01, 0.0)
    assert (camera.time_bound, tag.time_bound) == (0.0, 0.05)
    assert (tag.name, tag.angle, tag.angle_bound) == ("tag", pytest.approx(math.pi / 2), pytest.approx(math.pi / 180))
    assert [each.sensor.tolist() for each in LogReader(tmp_path / "out.jsonl").records()] == [[1], [0], [0], [0] * 4]
