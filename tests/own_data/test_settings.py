"""Settings are read strictly: every slip is told, with its place and the nearest right word."""

import math
import re
from pathlib import Path

import pytest
from helpers.own_data.settings_files import OF_BAGS, TEAM, of_robots

from experiments.own_data import read_settings
from experiments.own_data.kinds import STREAM_KINDS
from filter import InvalidInput

COMPASS = 'topic = "/imu", bound = 0.1'
PAGE = (Path(__file__).parents[2] / "docs/own-data.md").read_text()
MOTION = "longest = 0.1, distance_bound = 0.1, turn_bound = 0.1, direction_bound = 0.1, slip_bound = 0.1"
TWIST = "hold = 0.5, speed_bound = 0.1, turn_rate_bound = 0.1, direction_bound = 0.1, slip_rate = 0.1"


@pytest.fixture
def read(tmp_path):
    def read(text):
        (tmp_path / "my.toml").write_text(text)
        return read_settings(tmp_path / "my.toml")

    return read


def refused(read, text):
    with pytest.raises(InvalidInput) as error:
        read(text)
    return str(error.value)


def test_settings_that_work(read):
    settings = read(of_robots(OF_BAGS, compass=COMPASS))
    assert list(settings.facts.robots) == ["a", "b"]
    (stream,) = settings.streams
    assert (stream.kind, stream.robot, stream.source, stream.bounds) == ("compass", "a", "/imu", {"bound": 0.1})


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (OF_BAGS.replace("speed_limit = 1.0\n", "spede_limit = 1.0\n", 1), 'a key "speed_limit", here or in [team]'),
        (OF_BAGS + 'stamps = "header"\n', 'did you mean "stamp"'),
        (OF_BAGS + '\n[every_robot]\ncompas = { topic = "/imu" }\n', 'did you mean "compass"'),
        (OF_BAGS + "\n[evry_robot]\n", 'did you mean "every_robot"'),
        (OF_BAGS.replace("arena", "arenas"), 'did you mean "arena"'),
        (OF_BAGS.replace("[input]", '[input]\ntypes = "humbl"'), 'did you mean "humble"'),
        (OF_BAGS.replace("[input]", '[input]\nstamp_unit = "nanoseconds"'), "one of s, ms, us, ns"),
        (OF_BAGS.replace("1.0\n", "true\n"), "speed_limit: a number"),
        (OF_BAGS.replace("1.0\n", "nan\n"), "speed_limit: a number"),
        (OF_BAGS.replace("1.0\n", "-1.0\n"), "speed_limit: a number from 0 on"),
        (OF_BAGS.replace("[10, 10]", "[-11, 10]"), "the lower one first"),
        (OF_BAGS.replace("[10, 10]", "[inf, 10]"), "without open ends"),
        (OF_BAGS.replace("gate =", "a ="), '"a" for both'),
        (OF_BAGS.replace("speed", "ids = { 7 = 'gat' }\nspeed", 1), 'did you mean "gate"'),
        (
            OF_BAGS.replace("speed", "sensors = { tag = { position = [1, 0] } }\nspeed", 1),
            'a key "position_bound", the largest',
        ),
        (OF_BAGS.replace("speed", "sensors = { tag = { angle = 90, angle_bound = 0 } }\nspeed", 1), "angle: within a turn"),
        (OF_BAGS.replace("speed", "sensors = { tag = { place = 1 } }\nspeed", 1), 'came "place"'),
        (OF_BAGS.replace("speed", "sensors = { tag = { time_bound = -1 } }\nspeed", 1), "time_bound: how far off its stamps"),
    ],
)
def test_a_slip_in_what_is_known_of_the_team_is_told(read, text, told):
    assert told in refused(read, of_robots(text, compass=COMPASS))


@pytest.mark.parametrize(
    ("stream", "told"),
    [
        ({"compass": 'topic = "/imu", boundd = 0.1, bound = 0.1'}, 'did you mean "bound"'),
        ({"compass": 'topic = "/imu"'}, "without a bound there is no guarantee"),
        ({"compass": 'topic = "/imu"'}, '"k_sigma"'),
        ({"compass": 'topic = "/imu", bound = 0.1, k_sigma = 3'}, 'either "bound" or "k_sigma"'),
        ({"compass": "bound = 0.1"}, 'either "topic", of a bag, or "file"'),
        ({"compass": 'topic = "/imu", file = "imu.csv", bound = 0.1'}, 'either "topic", of a bag, or "file"'),
        ({"compass": 'topic = "/imu", bound = 5'}, 'unit = "degrees"'),
        ({"compass": 'topic = "/imu", bound = -0.1'}, "a bound from 0 on"),
        ({"compass": 'topic = "/imu", bound = [0.1, -0.1]'}, "low first"),
        ({"compass": 'topic = "/imu", bound = 0.1, unit = "degree"'}, 'did you mean "degrees"'),
        ({"compass": 'topic = "/imu", bound = 0.1, unit = "metres"'}, "among radians, degrees"),
        ({"compass": 'topic = "/imu", bound = 0.1, convention = "nde"'}, 'did you mean "ned"'),
        ({"compass": 'topic = "/{robto}/imu", bound = 0.1'}, 'did you mean "robot"'),
        ({"compass": 'topic = "/imu", bound = 0.1, target = "b"'}, "keys that are known"),
        ({"range": 'topic = "/r", bound = 0.1, convention = "ned"'}, "keys that are known"),
        ({"range": 'topic = "/r", bound = 0.1, relative_bound = 1.0'}, "below 1"),
        ({"bearing": 'topic = "/r", bearing = "b", bound = 3.2'}, "an angle of 180 degrees at most"),
        ({"detections": 'topic = "/r", range_bound = 0.1'}, 'a bound "bearing_bound"'),
        ({"odometry": 'topic = "/o", ' + MOTION.replace("longest", "longst")}, 'a key "longest"'),
        ({"odometry": 'topic = "/o", sideways = 1, ' + MOTION}, "true or false"),
        ({"odometry": 'topic = "/o", k_sigma = 3, ' + MOTION}, "keys that are known"),
        ({"twist": 'topic = "/t", ' + TWIST.replace("hold = 0.5, ", "")}, "how long it holds"),
        ({"position": 'topic = "/p", bound = [0.1]'}, "[in x, in y]"),
        ({"position": 'topic = "/p", radius = [0.1, 0.1]'}, "a number from 0 on"),
        ({"position": 'topic = "/p", bound = 0.1, radius = 0.1'}, "keys that are known"),
        ({"compass": 'topic = "/imu", bound = 0.1, clock_offset = "1"'}, "clock_offset: a number"),
        ({}, "at least one stream"),
    ],
)
def test_a_slip_in_a_stream_is_told_with_its_place(read, stream, told):
    said = refused(read, of_robots(OF_BAGS, **stream))
    assert told in said
    assert said.startswith("expected my.toml:")


NONE = [(TEAM, "robots"), ("team = 3", "what is known"), ("[team", "TOML"), ("\n[robots.a]\n", "team")]


@pytest.mark.parametrize(("text", "told"), NONE)
def test_what_are_no_settings_is_told(read, text, told):
    assert told in refused(read, text)


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(InvalidInput, match="a readable TOML file"):
        read_settings(tmp_path / "none.toml")


def test_a_robots_own_stream_stands_for_that_of_every_robot_and_false_for_none(read):
    text = f"{OF_BAGS}\n[robots.a]\n[robots.b]\ncompass = false\n[robots.c]\ncompass = {{ topic = '/c', bound = 0.2 }}\n"
    streams = read(text + f"[every_robot]\ncompass = {{ {COMPASS} }}\n").streams
    assert [(stream.robot, stream.source) for stream in streams] == [("a", "/imu"), ("c", "/c")]


def test_several_streams_of_a_kind_are_a_list(read):
    streams = read(f"{OF_BAGS}\n[robots.a]\ncompass = [{{ {COMPASS} }}, {{ topic = '/other', bound = 0.2 }}]\n").streams
    assert [stream.source for stream in streams] == ["/imu", "/other"]


def test_bounds_are_in_the_streams_own_unit(read):
    degrees = read(of_robots(OF_BAGS, compass='topic = "/imu", unit = "degrees", bound = 3, declination = 2')).streams[0]
    assert degrees.bounds["bound"] == pytest.approx(math.pi / 60)
    assert degrees.door.declination == pytest.approx(math.pi / 90)
    both = 'topic = "/d", unit = ["degrees", "millimetres"], range_bound = [-50, 100], bearing_bound = 3'
    detections = read(of_robots(OF_BAGS, detections=both)).streams[0]
    bounds = {"range_bound": (-0.05, 0.1), "range_relative_bound": 0.0, "bearing_bound": math.radians(3)}
    assert detections.bounds == bounds


def test_what_is_known_of_the_start_becomes_a_polygon_and_an_interval(read):
    start = 'start = { position = [1, 2], bound = 0.5, heading = 90, heading_bound = 10, unit = "degrees" }'
    text = f"{OF_BAGS}\n[robots.a]\n{start}\ncompass = {{ {COMPASS} }}\n"
    text += "[robots.b]\nstart = { vertices = [[0, 0], [1, 0], [0, 1]] }\n"
    first, second = read(text).facts.initial()
    assert first["vertices"] == [[0.5, 1.5], [1.5, 1.5], [1.5, 2.5], [0.5, 2.5]]
    assert first["heading"] == pytest.approx({"centre": math.pi / 2, "bound": math.pi / 18})
    assert second == {"record": "initial", "robot": "b", "vertices": [[0, 0], [1, 0], [0, 1]], "heading": None}


@pytest.mark.parametrize(
    ("start", "told"),
    [
        ("box = [[0, 0], [1, 1]], vertices = [[0, 0]]", "one of box, vertices and position"),
        ("position = [0, 0]", 'a key "bound"'),
        ("heading = 1.0", 'a key "heading_bound"'),
        ("heading = 90, heading_bound = 5", 'unit = "degrees"'),
        ("boks = [[0, 0], [1, 1]]", 'did you mean "box"'),
    ],
)
def test_a_slip_in_a_start_is_told(read, start, told):
    assert told in refused(read, f"{OF_BAGS}\n[robots.a]\nstart = {{ {start} }}\ncompass = {{ {COMPASS} }}\n")


def test_a_robots_own_limit_makes_limits_of_each(read):
    text = f"{OF_BAGS}\n[robots.a]\nspeed_limit = 0\ncompass = {{ {COMPASS} }}\n[robots.b]\n"
    header = read(text).facts.header(0.0)
    assert header["speed_limit"] == {"a": 0.0, "b": 1.0}
    assert header["turn_rate_limit"] == 2.0


def test_a_sensor_that_the_team_does_not_have_is_told(read):
    told = refused(read, of_robots(OF_BAGS, compass=COMPASS + ', sensor = "tag"'))
    assert 'compass: sensor: a name in [team.sensors]: there is none; came "tag"' in told


@pytest.mark.parametrize("example", re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL))
def test_the_examples_for_newcomers_can_be_read(read, example):
    settings = read(example)
    assert {stream.robot for stream in settings.streams} == {"alice", "bob"}


def test_every_kind_of_stream_and_every_key_is_explained_to_newcomers():
    keys = {name for kind in STREAM_KINDS.values() for name in (*kind.fields, *kind.bounds)}
    assert sorted(word for word in {*STREAM_KINDS, *keys} if f"`{word}`" not in PAGE) == []
