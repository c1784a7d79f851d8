"""What is written reads back to the same polygons, and the same run gives the same bytes."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from helpers.teams import write_log
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros2.decoder import DecoderFactory as RosFactory
from pyarrow import parquet

from experiments.following.scenarios import from_log
from experiments.following.steps import steps
from experiments.regions import FILES, FORMATS, regions_writer, rows_of
from experiments.regions import writers as writers_module
from experiments.regions.stamps import nanoseconds
from filter import ExtendedKalmanFilter, InvalidInput, RobustFilter, SetMembershipFilter

NAMES = ("alice", "bob")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("log") / "log.jsonl")


def followed(log, make):
    scenario = from_log(log)
    return list(steps(make(scenario.team), scenario, warm=False))


@pytest.fixture(scope="module")
def sets(log):
    return followed(log, SetMembershipFilter)


@pytest.fixture(scope="module")
def robust(log):
    return followed(log, RobustFilter)


@pytest.fixture(scope="module")
def kalman(log):
    return followed(log, ExtendedKalmanFilter)


def written(folder, form, made, beside=None):
    """Write steps, with a Kalman filter's beside them or without; return the file."""
    writer = regions_writer(form, folder)
    for step, other in zip(made, beside or [None] * len(made), strict=True):
        writer.write(rows_of(NAMES, step.frame.time, step.belief, other and other.belief))
    writer.close()
    return folder / FILES[form]


def lines_of(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def read(path):
    """Return what an MCAP file says: by topic, the stamp and the message each."""
    found = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[RosFactory(), ProtobufFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


def test_a_json_line_has_every_float_of_a_robots_region(tmp_path, sets):
    lines = iter(lines_of(written(tmp_path, "jsonl", sets)))
    for step in sets:
        for robot, region in enumerate(step.belief.regions):
            line = next(lines)
            assert list(line) == ["time", "robot", "outer", "margin_m", "inner", "heading", "area_m2", "in_force"]
            assert (line["time"], line["robot"]) == (step.frame.time, NAMES[robot])
            assert line["outer"] == region.outer.vertices.tolist()
            assert line["margin_m"] == region.outer.margin
            assert line["inner"] == region.inner.vertices.tolist()
            assert line["area_m2"] == region.outer.area
            headings = step.belief.headings
            assert line["heading"] == {"centre": headings.centre[robot], "bound": headings.bound[robot]}
            assert line["in_force"] is True
    assert next(lines, None) is None


@pytest.mark.parametrize("names", ["sets", "robust", "kalman", "sets kalman", "robust kalman"])
def test_a_parquet_table_has_the_same_rows_as_the_json_lines(tmp_path, request, names, monkeypatch):
    monkeypatch.setattr("experiments.regions.as_parquet.ROWS", 6)
    made, *others = map(request.getfixturevalue, names.split())
    others = others[0] if others else None
    rows = parquet.read_table(written(tmp_path, "parquet", made, others)).to_pylist()
    assert rows == [{"ekf": None} | line for line in lines_of(written(tmp_path, "jsonl", made, others))]
    assert parquet.ParquetFile(tmp_path / "regions.parquet").num_row_groups == 3


def test_a_kalman_filter_has_an_estimate_and_no_region(tmp_path, kalman):
    belief = kalman[-1].belief
    for robot, line in enumerate(lines_of(written(tmp_path, "jsonl", kalman[-1:]))):
        nothing = ("outer", "margin_m", "inner", "heading", "area_m2")
        assert [line[name] for name in nothing] == [None] * 5
        assert line["in_force"] is False
        place = slice(3 * robot, 3 * robot + 3)
        assert [*line["ekf"]["position"], line["ekf"]["heading"]] == belief.mean[robot].tolist()
        assert line["ekf"]["covariance"] == belief.covariance[place, place].tolist()


def inside(corners, point):
    """Return whether a polygon, counter-clockwise, contains a point, without any rounding."""
    exact = [tuple(Fraction(value) for value in corner) for corner in corners]
    x, y = map(Fraction, point)
    edges = zip(exact, [*exact[1:], exact[0]], strict=True)
    return all((b[0] - a[0]) * (y - a[1]) >= (b[1] - a[1]) * (x - a[0]) for a, b in edges)


def test_a_polygon_stamped_contains_the_region(tmp_path, sets):
    messages = read(written(tmp_path, "mcap", sets))
    for robot, name in enumerate(NAMES):
        for step, (stamp, message) in zip(sets, messages[f"/{name}/region"], strict=True):
            assert stamp == nanoseconds(step.frame.time)
            header = message.header
            assert (header.stamp.sec * 10**9 + header.stamp.nanosec, header.frame_id) == (stamp, "map")
            corners = [(point.x, point.y) for point in message.polygon.points]
            assert all(float(np.float32(value)) == value for corner in corners for value in corner)
            outer = step.belief.regions[robot].outer
            assert all(inside(corners, corner) for corner in outer.vertices.tolist())


def test_a_file_of_ros_alone_has_the_same_polygons_and_poses(tmp_path, sets, kalman):
    ros, all_of_it = (read_raw(written(tmp_path, form, sets, kalman)) for form in ("ros2", "mcap"))
    assert sorted(ros) == sorted(f"/{name}/{what}" for name in NAMES for what in ("ekf", "region"))
    assert {topic: messages for topic, messages in all_of_it.items() if topic != "/regions"} == ros


def read_raw(path):
    """Return the bytes of the messages by topic."""
    found = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            found.setdefault(channel.topic, []).append((message.log_time, message.data))
    return found


def test_another_reader_of_bags_takes_a_file_of_ros_alone(tmp_path, sets):
    highlevel = pytest.importorskip("rosbags.highlevel")
    with highlevel.AnyReader([written(tmp_path, "ros2", sets)]) as bag:
        chosen = [each for each in bag.connections if each.topic == "/alice/region"]
        read = [(stamp, bag.deserialize(raw, each.msgtype)) for each, stamp, raw in bag.messages(chosen)]
    assert [stamp for stamp, _ in read] == [nanoseconds(step.frame.time) for step in sets]
    for (_, message), step in zip(read, sets, strict=True):
        corners = [(float(point.x), float(point.y)) for point in message.polygon.points]
        assert all(inside(corners, corner) for corner in step.belief.regions[0].outer.vertices.tolist())


def test_foxglove_draws_the_region_itself_with_its_name(tmp_path, sets):
    messages = read(written(tmp_path, "mcap", sets))["/regions"]
    for step, (stamp, scene) in zip(sets, messages, strict=True):
        assert [entity.id for entity in scene.entities] == list(NAMES)
        for entity, region in zip(scene.entities, step.belief.regions, strict=True):
            assert (entity.frame_id, entity.timestamp.ToNanoseconds()) == ("map", stamp)
            (line,), (fill,), (text,) = entity.lines, entity.triangles, entity.texts
            assert line.type == line.LINE_LOOP
            assert [[point.x, point.y] for point in line.points] == region.outer.vertices.tolist() == outline(fill)
            assert text.text == entity.id
            assert line.pose.orientation.w == fill.pose.orientation.w == text.pose.orientation.w == 1.0


def outline(fill):
    """Return the corners of a fan of triangles that all go the same way round as its corners."""
    triples = [tuple(fill.indices[k : k + 3]) for k in range(0, len(fill.indices), 3)]
    assert triples == [(0, k, k + 1) for k in range(1, len(fill.points) - 1)]
    return [[point.x, point.y] for point in fill.points]


def test_what_is_not_in_force_has_a_red_outline(tmp_path, log):
    scenario = from_log(write_log(tmp_path / "log.jsonl"))
    made = list(steps(SetMembershipFilter(scenario.team), scenario, warm=False))
    for k, step in enumerate(made):
        guarantee = step.belief.guarantee.suspended(0.4, "a lie") if k >= 4 else step.belief.guarantee
        made[k] = replace(step, belief=replace(step.belief, guarantee=guarantee))
    scenes = [scene for _, scene in read(written(tmp_path, "mcap", made))["/regions"]]
    red = [scene.entities[0].lines[0].color.r == 1.0 for scene in scenes]
    told = [line["in_force"] for line in lines_of(written(tmp_path, "jsonl", made))[::2]]
    assert red == [not in_force for in_force in told] == [k >= 4 for k in range(8)]


@pytest.mark.parametrize("alone", [True, False])
def test_a_kalman_filters_pose_is_one_of_ros(tmp_path, sets, kalman, alone):
    messages = read(written(tmp_path, "mcap", kalman if alone else sets, None if alone else kalman))
    assert ("/regions" in messages, "/bob/region" in messages) == (not alone, not alone)
    for step, (_, message) in zip(kalman, messages["/bob/ekf"], strict=True):
        x, y, turn = step.belief.mean[1].tolist()
        pose = message.pose.pose
        assert (pose.position.x, pose.position.y, pose.position.z) == (x, y, 0.0)
        assert 2 * np.arctan2(pose.orientation.z, pose.orientation.w) == pytest.approx(np.arctan2(np.sin(turn), np.cos(turn)))
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        assert np.array_equal(covariance[np.ix_([0, 1, 5], [0, 1, 5])], step.belief.covariance[3:, 3:])
        assert np.count_nonzero(covariance) == 9


@pytest.mark.parametrize("form", FORMATS)
def test_the_same_run_gives_the_same_bytes(tmp_path, log, form):
    files = []
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        others = followed(log, ExtendedKalmanFilter)
        files.append(written(tmp_path / name, form, followed(log, SetMembershipFilter), others).read_bytes())
    assert files[0] == files[1]


def test_a_run_that_is_killed_leaves_whole_json_lines(tmp_path, sets):
    writer = regions_writer("jsonl", tmp_path)
    for count, step in enumerate(sets, 1):
        writer.write(rows_of(NAMES, step.frame.time, step.belief))
        assert len(lines_of(tmp_path / "regions.jsonl")) == 2 * count
    writer.close()


@pytest.mark.parametrize(("time", "expected"), [(0.1, 10**8), (1e9 + 0.1, 10**18 + 100000024), (0.0, 0), (4e-10, 0)])
def test_stamps_are_the_nearest_nanosecond(time, expected):
    assert nanoseconds(time) == expected


@pytest.mark.parametrize("ns", [1_735_689_600_123_456_789, 987_654_321, 2**53 + 1])
def test_stamps_of_bags_come_back_as_near_as_seconds_tell(ns):
    assert abs(nanoseconds(ns / 1e9) - ns) <= np.spacing(ns / 1e9) * 1e9


@pytest.mark.parametrize("time", [-1e-9, 2.0**31])
def test_times_that_no_stamp_can_hold_are_refused(time):
    with pytest.raises(InvalidInput, match="times from 0"):
        nanoseconds(time)


@pytest.mark.parametrize(("form", "package"), [("mcap", "mcap"), ("mcap", "foxglove_schemas_protobuf"), ("parquet", "pyarrow")])
def test_a_package_that_is_missing_is_named_with_what_to_do(tmp_path, monkeypatch, form, package):
    monkeypatch.setattr(writers_module, "find_spec", lambda name: None if name == package else object())
    name = package.replace("_", "-")
    with pytest.raises(InvalidInput, match=rf"the package {name} to write {form} \(pip install {name};"):
        regions_writer(form, tmp_path)
    assert not list(tmp_path.iterdir())
