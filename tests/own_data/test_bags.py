"""Bags of ROS 1 and ROS 2: every kind of message, what is left out and why, and recordings that are not whole."""

import gzip
import json
import math
import shutil
import sys

import pytest
from helpers.own_data.made_bags import FORMS, stamped, turned, without_definitions, write_bag
from helpers.own_data.settings_files import OF_BAGS, of_robots

from experiments.convert import main
from experiments.show.command import BAD_INPUT

SECOND = 10**9
ODOMETRY, IMU, RANGE = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu", "sensor_msgs/msg/Range"
POSE, POSE_COVARIANCE = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped"
TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
FIX, TRANSFORMS, TEXT = "sensor_msgs/msg/NavSatFix", "tf2_msgs/msg/TFMessage", "std_msgs/msg/String"
TREE = "geometry_msgs/TransformStamped[] transforms\n"
TAG = "=" * 80 + "\nMSG: my_msgs/Tag\nint32 id\nfloat32 cm\nfloat64 deg\n"
TAGS = {"my_msgs/msg/Tags": "std_msgs/Header header\nTag[] tags\n" + TAG}
MOTION = "longest = 1.0, distance_bound = 0.1, turn_bound = 0.1, direction_bound = 0.1, slip_bound = 0.1"
COMMANDED = "hold = 0.5, speed_bound = 0.1, turn_rate_bound = 0.2, direction_bound = 0.3, slip_rate = 0.4"
HEADING = 'topic = "/imu", bound = 0.1'


@pytest.fixture
def converted(tmp_path, capsys):
    """Return a function that converts a bag; it returns exit code, records after the initial ones, and what was told."""

    def converted(path, settings):
        (tmp_path / "my.toml").write_text(settings)
        out = tmp_path / "out.jsonl"
        out.unlink(missing_ok=True)
        code = main([str(tmp_path / "my.toml"), str(path), str(out)])
        records = [json.loads(line) for line in out.read_text().splitlines()][3:] if out.exists() else []
        return code, records, capsys.readouterr().err

    return converted


@pytest.fixture(params=FORMS)
def bag(request, tmp_path):
    return lambda said, definitions=None: write_bag(tmp_path / f"my.{request.param}", said, definitions)


def imu(time, yaw, topic="/imu", **fields):
    return topic, IMU, time + 1000, stamped(time, orientation=turned(yaw), **fields)


def pose(x, y, yaw):
    return {"position": {"x": x, "y": y}, "orientation": turned(yaw)}


def test_a_compass_is_the_yaw_of_an_orientation(bag, converted):
    code, records, said = converted(bag([imu(SECOND, 0.5), imu(2 * SECOND, -3.0)]), of_robots(OF_BAGS, compass=HEADING))
    assert (code, said) == (0, "")
    assert [record["time"] for record in records] == [1.0, 2.0]
    assert [record["heading"] for record in records] == pytest.approx([0.5, -3.0])


def test_increments_are_between_poses_and_a_twist_is_a_twist(bag, converted):
    """A robot that drives half a metre along its heading, turns, and once slides to its left."""
    poses = [(0.0, 0.0, math.pi / 2), (0.0, 0.5, math.pi / 2), (0.0, 0.5, math.pi), (0.0, 0.2, math.pi)]
    twist = {"twist": {"linear": {"x": 0.3, "y": 0.0}, "angular": {"z": -0.2}}}
    said = [
        ("/odom", ODOMETRY, k * SECOND, stamped(k * SECOND, pose={"pose": pose(*each)}, twist=twist))
        for k, each in enumerate(poses, 1)
    ]
    path, streams = bag(said), {"odometry": f'topic = "/odom", {MOTION}', "twist": f'topic = "/odom", {COMMANDED}'}
    code, records, _ = converted(path, of_robots(OF_BAGS, **streams))
    assert code == 0
    moved = [record for record in records if record["record"] == "odometry"]
    assert [(record["start"], record["time"]) for record in moved] == [(1.0, 2.0), (2.0, 3.0), (3.0, 4.0)]
    assert [record["distance"] for record in moved] == pytest.approx([0.5, 0.0, 0.0], abs=1e-12)
    assert [record["turn"] for record in moved] == pytest.approx([0.0, math.pi / 2, 0.0], abs=1e-12)
    assert [record["slip_bound"] for record in moved] == pytest.approx([0.1, 0.1, 0.4])
    twists = [record for record in records if record["record"] == "twist"]
    assert len(twists) == 4
    assert twists[0] == {
        "record": "twist",
        "time": 1.0,
        "robot": "a",
        "speed": 0.3,
        "speed_bound": 0.1,
        "turn_rate": -0.2,
        "turn_rate_bound": 0.2,
        "direction_bound": 0.3,
        "slip_rate": 0.4,
        "hold": 0.5,
    }
    streams["odometry"] += ", sideways = true"
    moved = [record for record in converted(path, of_robots(OF_BAGS, **streams))[1] if record["record"] == "odometry"]
    assert [record["distance"] for record in moved] == pytest.approx([0.5, 0.0, 0.3], abs=1e-12)
    assert [record["aside"] for record in moved] == pytest.approx([0.0, 0.0, math.pi / 2], abs=1e-12)
    assert [record["slip_bound"] for record in moved] == pytest.approx([0.1, 0.1, 0.1])


def test_a_gap_in_odometry_and_a_stamp_that_does_not_advance_are_left_out(bag, converted):
    said = [("/odom", ODOMETRY, k, stamped(time, pose={"pose": pose(time / SECOND, 0.0, 0.0)})) for k, time in enumerate(TIMES)]
    code, records, told = converted(bag(said), of_robots(OF_BAGS, odometry=f'topic = "/odom", {MOTION}'))
    assert code == 0
    assert [(record["start"], record["time"], record["distance"]) for record in records] == [(1.0, 1.5, 0.5), (4.0, 4.5, 0.5)]
    assert "1 of 6 messages: more than 1 s after the message before" in told
    assert "2 of 6 messages: its stamp is not after that of the message before" in told


TIMES = [SECOND, SECOND * 3 // 2, SECOND * 3 // 2, SECOND, 4 * SECOND, 4 * SECOND + SECOND // 2]


def test_commands_without_a_header_are_stamped_when_they_were_received(bag, converted):
    command = {"linear": {"x": 0.5, "y": -0.5}, "angular": {"z": 0.1}}
    said = [("/cmd", TWIST, SECOND, command), ("/stamped", TWIST_STAMPED, SECOND, stamped(2 * SECOND, twist=command))]
    path = bag(said)
    code, _, told = converted(path, of_robots(OF_BAGS, twist=f'topic = "/cmd", {COMMANDED}'))
    assert code == BAD_INPUT
    assert 'stamp = "received"' in told
    received = f'topic = "/cmd", stamp = "received", clock_offset = 10.5, sideways = true, {COMMANDED}'
    (record,) = converted(path, of_robots(OF_BAGS, twist=received))[1]
    assert record["time"] == 11.5
    assert (record["speed"], record["aside"]) == pytest.approx((math.sqrt(0.5), -math.pi / 4))
    (record,) = converted(path, of_robots(OF_BAGS, twist=f'topic = "/stamped", {COMMANDED}'))[1]
    assert (record["time"], record["speed"], record["slip_rate"]) == (2.0, 0.5, 0.9)


def test_ranges_are_those_that_their_sensor_can_measure(bag, converted):
    limits = {"min_range": 0.5, "max_range": 9.0}
    values = [(1.25, limits), (0.25, limits), (9.5, limits), (9.5, {}), (-1.0, {}), (math.inf, limits), (math.nan, {})]
    said = [("/uwb/a/b", RANGE, k, stamped(k * SECOND, range=value, **more)) for k, (value, more) in enumerate(values, 1)]
    code, records, told = converted(bag(said), of_robots(OF_BAGS, range='topic = "/uwb/{robot}/{target}", bound = [0.0, 0.5]'))
    assert code == 0
    assert [(record["target"], record["range"], record["bound"]) for record in records] == [
        ("b", 1.25, [0.0, 0.5]),
        ("b", 9.5, [0.0, 0.5]),
    ]
    assert "2 of 7 messages: its range is not from min_range to max_range" in told
    assert "1 of 7 messages: its range is below 0" in told
    assert "2 of 7 messages: range is not a finite number" in told


def test_who_is_measured_is_told_by_the_topic(bag, converted):
    said = [(f"/uwb/a/{name}", RANGE, 1, stamped(SECOND, range=2.0)) for name in ("a", "b", "7", "ghost")]
    said.append(("/uwb/b/a", RANGE, 1, stamped(SECOND, range=2.0)))
    stream = 'topic = "/uwb/{robot}/{target}", bound = 0.1, ids = { 7 = "gate" }'
    code, records, told = converted(bag(said), of_robots(OF_BAGS, range=stream))
    assert code == 0
    assert sorted(record.get("target", record.get("landmark")) for record in records) == ["b", "gate"]
    assert "/uwb/a/a, sensor_msgs/msg/Range, 1 messages: its name says that the robot measures itself" in told
    assert '/uwb/a/ghost, sensor_msgs/msg/Range, 1 messages: no robot or landmark is called "ghost"' in told
    assert "/uwb/b/a, sensor_msgs/msg/Range, 1 messages: the settings do not name it" in told


def test_a_pose_is_a_position_a_compass_or_the_truth(bag, converted):
    covariance = [0.0] * 36
    covariance[0], covariance[7], covariance[35] = 0.04, 0.09, 0.01
    fix = {"pose": {"pose": pose(1.0, 2.0, 0.5), "covariance": covariance}}
    said = [
        ("/amcl", POSE_COVARIANCE, 1, stamped(SECOND, **fix)),
        ("/true", POSE, 2, stamped(SECOND, pose=pose(3.0, 4.0, 0.5))),
    ]
    path, streams = bag(said), {"position": 'topic = "/amcl", k_sigma = 3', "compass": 'topic = "/amcl", k_sigma = 2'}
    records = converted(path, of_robots(OF_BAGS, **streams, truth='topic = "/true"'))[1]
    assert [record["record"] for record in records] == ["compass", "position", "truth"]
    assert records[0]["bound"] == pytest.approx(0.2)
    assert records[1]["position"] == [1.0, 2.0]
    assert records[1]["bound"] == pytest.approx([0.6, 0.9])
    assert (records[2]["position"], records[2]["heading"]) == ([3.0, 4.0], pytest.approx(0.5))
    (record,) = converted(path, of_robots(OF_BAGS, position='topic = "/true", radius = 0.25'))[1]
    assert record == {"record": "position", "time": 1.0, "robot": "a", "position": [3.0, 4.0], "radius": 0.25}
    code, _, told = converted(path, of_robots(OF_BAGS, position='topic = "/true", k_sigma = 3'))
    assert code == BAD_INPUT
    assert "no covariance for k_sigma" in told


def test_a_covariance_of_zero_is_no_bound(bag, converted):
    code, _, told = converted(bag([imu(SECOND, 0.5)]), of_robots(OF_BAGS, compass='topic = "/imu", k_sigma = 3'))
    assert code == BAD_INPUT
    assert '/imu, message 1: a variance above 0, to take k_sigma deviations of; else declare "bound"' in told


def test_a_truth_without_orientation_has_no_heading(bag, converted):
    said = [("/true", POSE, 1, stamped(SECOND, pose={"position": {"x": 3.0, "y": 4.0}}))]
    assert converted(bag(said), of_robots(OF_BAGS, truth='topic = "/true"'))[1][0]["heading"] is None


def test_an_orientation_that_is_none_is_left_out(bag, converted):
    said = [imu(SECOND, 0.5), ("/imu", IMU, 2, stamped(2 * SECOND))]
    code, records, told = converted(bag(said), of_robots(OF_BAGS, compass=HEADING))
    assert (code, len(records)) == (0, 1)
    assert "left out: /imu, sensor_msgs/msg/Imu, 1 of 2 messages: its orientation is a quaternion whose length is not 1" in told


def test_a_satellite_fix_is_a_position_about_the_origin(bag, converted):
    pytest.importorskip("pyproj")
    place = {"latitude": 48.001, "longitude": 11.0}
    said = [
        ("/gps", FIX, 1, stamped(SECOND, **place)),
        ("/gps", FIX, 2, stamped(2 * SECOND, **place, status={"status": -1})),
    ]
    path, gps = bag(said), 'topic = "/gps", bound = 2.5'
    assert "[team] origin" in converted(path, of_robots(OF_BAGS, position=gps))[2]
    with_origin = OF_BAGS.replace("[team]", "[team]\norigin = [48.0, 11.0]")
    _, (record,), told = converted(path, of_robots(with_origin, position=gps))
    assert record["position"] == pytest.approx([0.0, 111.2], abs=0.1)
    assert "1 of 2 messages: its status says that there is no fix" in told
    assert "neither unit nor convention" in converted(path, of_robots(with_origin, position=gps + ', convention = "ned"'))[2]


def test_arrays_of_a_type_of_ones_own_are_read_by_paths(bag, converted):
    tags = [{"id": 7, "cm": 150.0, "deg": 90.0}, {"id": 9, "cm": 50.0, "deg": 0.0}, {"id": 3, "cm": 25.0, "deg": -90.0}]
    path = bag([("/tags", "my_msgs/msg/Tags", 1, stamped(SECOND, tags=tags))], TAGS)
    paths = 'id = "tags[*].id", range = "tags[*].cm", bearing = "tags[*].deg"'
    stream = f'topic = "/tags", {paths}, unit = ["degrees", "centimetres"], convention = "ned", ids = {{ 7 = "b" }}'
    code, records, told = converted(
        path,
        of_robots(
            OF_BAGS.replace("[team]", '[team]\nids = { 3 = "gate" }'),
            detections=f"{stream}, range_bound = [-10, 20], range_relative_bound = 0.01, bearing_bound = [-9, 18]",
        ),
    )
    assert code == 0, told
    assert [record["record"] for record in records] == ["bearing", "range"] * 2
    assert records[0]["target"] == records[1]["target"] == "b"
    assert records[2]["landmark"] == records[3]["landmark"] == "gate"
    assert records[0]["bearing"] == pytest.approx(-math.pi / 2)
    assert records[0]["bound"] == pytest.approx([-math.pi / 10, math.pi / 20])
    assert (records[1]["range"], records[1]["bound"], records[1]["relative_bound"]) == (1.5, [-0.1, 0.2], 0.01)
    assert 'left out: /tags, my_msgs/msg/Tags, 1 entries: no robot or landmark is called "9"' in told


def test_mountings_are_read_and_told_as_they_have_no_bounds(bag, converted):
    turn = {"translation": {"x": 0.2, "z": 0.1}, "rotation": turned(1.0)}
    static = {"transforms": [stamped(SECOND, child_frame_id="laser", transform=turn)]}
    static["transforms"][0]["header"]["frame_id"] = "base_link"
    said = [("/tf_static", TRANSFORMS, 1, static), ("/tf", TRANSFORMS, 1, {}), imu(SECOND, 0.5), ("/chat", TEXT, 2, {})]
    code, _, told = converted(bag(said, {TRANSFORMS: TREE}), of_robots(OF_BAGS, compass=HEADING))
    assert code == 0
    assert told.splitlines() == [
        "left out: /chat, std_msgs/msg/String, 1 messages: the settings do not name it",
        "left out: /tf, tf2_msgs/msg/TFMessage, 1 messages: transforms that move are not read",
        "left out: /tf_static, tf2_msgs/msg/TFMessage, 1 messages: they have no bounds; "
        "say how sensors are mounted in [team.sensors]: base_link to laser: 0.2, 0, 0.1 m, yaw 1 rad",
    ]


@pytest.mark.parametrize(
    ("stream", "told"),
    [
        ({"compass": 'topic = "/imus", bound = 0.1'}, 'a topic that is there: did you mean "/imu"?'),
        ({"compass": 'file = "/imu", bound = 0.1'}, '"topic", as the input is a bag'),
        ({"compass": 'topic = "/chat", bound = 0.1'}, "without paths are understood: sensor_msgs/msg/Imu"),
        ({"compass": 'topic = "/chat", heading = "dta", bound = 0.1'}, 'a field of std_msgs/msg/String: did you mean "data"?'),
        (
            {"compass": 'topic = "/chat", heading = "data", bound = 0.1'},
            'stamp = "received", as std_msgs/msg/String has no header',
        ),
        ({"compass": f'{HEADING}, stamp_unit = "ns"'}, 'no "stamp_unit" where stamp = "header"'),
        ({"compass": f'{HEADING}, stamp = "header.stam"'}, 'did you mean "stamp"'),
        (
            {"compass": 'topic = "/chat", stamp = "received", heading = "data", bound = 0.1'},
            "/chat, message 1: heading: a number",
        ),
        ({"bearing": 'topic = "/imu", bearing = "orientation.z", bound = 0.1'}, 'who is measured: "target", "id" or {target}'),
        ({"compass": 'topic = "/{target}", bound = 0.1'}, "nobody else"),
    ],
)
def test_settings_that_do_not_fit_the_bag_are_told(bag, converted, stream, told):
    code, _, said = converted(bag([imu(SECOND, 0.5), ("/chat", TEXT, 2, {"data": "hello"})]), of_robots(OF_BAGS, **stream))
    assert code == BAD_INPUT
    assert told in said


def test_a_stamp_has_to_be_declared_and_filled_in(bag, converted):
    path = bag([("/imu", IMU, 1_700_000_000 * SECOND, {"orientation": turned(0.5)})])
    assert (
        'stamp = "header", or "received"'
        in converted(path, of_robots(OF_BAGS.replace('stamp = "header"', ""), compass=HEADING))[2]
    )
    assert 'say stamp = "received"' in converted(path, of_robots(OF_BAGS, compass=HEADING))[2]
    (record,) = converted(path, of_robots(OF_BAGS.replace("header", "received"), compass=HEADING))[1]
    assert record["time"] == 1.7e9


def test_bags_without_definitions_need_to_be_told_where_they_are_from(tmp_path, converted):
    path = write_bag(tmp_path / "my.db3", [imu(SECOND, 0.5), ("/tags", "my_msgs/msg/Tags", 1, stamped(SECOND))], TAGS)
    file = without_definitions(path)
    settings = of_robots(OF_BAGS, compass=HEADING)
    code, _, told = converted(path, settings)
    assert code == BAD_INPUT
    assert 'the definition of its type is missing; in the settings, [input] types = "humble"' in told
    for place in (path, file):
        code, records, told = converted(place, settings.replace("[input]", '[input]\ntypes = "humble"'))
        assert (code, len(records)) == (0, 1)
        assert "left out: /tags, my_msgs/msg/Tags, 1 messages: the definition of its type is missing" in told
    (tmp_path / "my_msgs/msg").mkdir(parents=True)
    (tmp_path / "my_msgs/msg/Tags.msg").write_text(TAGS["my_msgs/msg/Tags"])
    own = '[input]\ntypes = "humble"\ndefinitions = ["my_msgs/msg/Tags.msg"]'
    assert (
        "/tags, my_msgs/msg/Tags, 1 messages: the settings do not name it"
        in converted(path, settings.replace("[input]", own))[2]
    )


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.6, 0.9, 0.98])
def test_a_bag_that_is_cut_off_is_told_with_what_mends_it(bag, converted, tmp_path, share):
    whole = bag([imu(k * SECOND, 0.5) for k in range(1, 400)])
    file = next(whole.glob("*.db3")) if whole.is_dir() else whole
    cut = tmp_path / f"cut{file.suffix}"
    cut.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])
    code, records, told = converted(cut, of_robots(OF_BAGS, compass=HEADING))
    assert (code, records) == (BAD_INPUT, [])
    assert "is mended by" in told or "a topic that is there" in told
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_a_bag_without_messages_is_told(bag, converted):
    code, _, told = converted(bag([]), of_robots(OF_BAGS, compass=HEADING))
    assert code == BAD_INPUT
    assert "a topic that is there" in told


@pytest.mark.parametrize(("package", "stream"), [("rosbags.highlevel", HEADING), ("pyproj", 'topic = "/gps", bound = 2.5')])
def test_a_package_that_is_not_there_is_told(bag, converted, monkeypatch, package, stream):
    place = stamped(SECOND, latitude=48.0, longitude=11.0)
    path, kind = bag([imu(SECOND, 0.5), ("/gps", FIX, 1, place)]), "compass" if stream == HEADING else "position"
    monkeypatch.setitem(sys.modules, package, None)
    code, _, told = converted(path, of_robots(OF_BAGS.replace("[team]", "[team]\norigin = [48.0, 11.0]"), **{kind: stream}))
    assert code == BAD_INPUT
    assert "pip install 'corral[data]'" in told


def test_poses_so_far_apart_that_nobody_knows_how_a_robot_turned_are_refused(bag, converted):
    said = [("/odom", ODOMETRY, 1, stamped(SECOND, pose={"pose": pose(0.0, 0.0, 0.0)}))]
    code, _, told = converted(bag(said), of_robots(OF_BAGS, odometry=f'topic = "/odom", {MOTION.replace("1.0", "1.6")}'))
    assert code == BAD_INPUT
    assert "turns by less than half a circle" in told


def test_messages_of_another_type_than_is_said_are_told(tmp_path, converted):
    """Jazzy's ranges have a variance, humble's have not."""
    path = write_bag(tmp_path / "my.db3", [("/uwb", RANGE, 1, stamped(SECOND, range=1.0))])
    without_definitions(path)
    settings = of_robots(
        OF_BAGS.replace("[input]", '[input]\ntypes = "jazzy"'), range='topic = "/uwb", target = "b", bound = 0.1'
    )
    code, _, told = converted(path, settings)
    assert code == BAD_INPUT
    assert "with messages as ROS 2 jazzy has them" in told


def test_what_is_no_recording_is_told(tmp_path, converted):
    (tmp_path / "my.txt").write_text("x")
    (tmp_path / "my.bag").write_bytes(gzip.compress(b"x"))
    for name, told in (("none.bag", "which is not there"), ("my.txt", "a file .bag, .mcap"), ("my.bag", "is mended by")):
        code, _, said = converted(tmp_path / name, of_robots(OF_BAGS, compass=HEADING))
        assert code == BAD_INPUT
        assert told in said
    folder = write_bag(tmp_path / "my.db3", [imu(SECOND, 0.5)])
    (folder / "metadata.yaml").unlink()
    assert "is mended by ros2 bag reindex" in converted(folder, of_robots(OF_BAGS, compass=HEADING))[2]
    shutil.rmtree(folder)
