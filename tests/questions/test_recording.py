import numpy as np
import pytest
from helpers.recordings import rerun, rows_of

from experiments.following.simulated import from_simulator
from experiments.following.steps import steps
from experiments.show.blueprint import INDIVIDUALLY
from experiments.show.colours import colour_of, mixed
from experiments.show.drawing import TRAIL, Drawing, Strips
from experiments.show.recording import Recording
from filter import AngularIntervals, Bearing, Frame, Polygon, Range, SetMembershipFilter, Team, Truth
from sim.episode import episode

WALLS = np.array([[-2.1, -2.0, -2.0, 2.0]])
TEAM = Team(2, landmarks=[[0.0, 1.0]], arena=[[-2, -2], [2, 2]])
TRUTH = Truth(np.array([[0.1, 0.0], [1.0, 0.2]]), np.array([0.5, np.pi]))


def belief_at(time, middles=((0.0, 0.0), (1.0, 0.0))):
    boxes = [Polygon.box(np.array(middle) - 0.5, np.array(middle) + 0.5) for middle in middles]
    return SetMembershipFilter(TEAM).start(time, boxes, AngularIntervals.circles(2))


def frame_at(time, measurements=(), truth=TRUTH):
    return Frame(time, None, measurements, truth)


def record(path, frames, team=TEAM, walls=WALLS, recording_id="test"):
    with Recording(path, team, recording_id=recording_id, walls=walls, wall_height=0.3) as recording:
        for frame in frames:
            recording.add(frame, belief_at(frame.time))
    return path


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A short run of three simulated robots: the recording and the steps it was made from."""
    path = tmp_path_factory.mktemp("run") / "run.rrd"
    scenario = from_simulator(episode(robots=3, duration=1.5, seed=4), 10.0)
    made = []
    walls = {"walls": scenario.walls, "wall_height": scenario.wall_height}
    with Recording(path, scenario.team, recording_id="4", **walls) as recording:
        for step in steps(SetMembershipFilter(scenario.team), scenario):
            recording.add(step.frame, step.belief)
            made.append(step)
        recording.event("the end", "WARN")
    return path, made


def test_a_recording_verifies_and_a_cut_off_one_does_not(run, tmp_path):
    checked = rerun("verify", run[0])
    assert checked.returncode == 0, checked.stderr
    cut = tmp_path / "cut.rrd"
    cut.write_bytes(run[0].read_bytes()[:-100])
    assert rerun("verify", cut).returncode != 0


def test_every_outer_polygon_is_in_the_recording_once_a_step_and_closed(run):
    path, made = run
    for robot in range(3):
        rows = rows_of(path, f"/world/outer/r{robot}", "LineStrips3D:strips")
        assert [row["step"] for row in rows] == list(range(len(made)))
        assert [row["t"].total_seconds() for row in rows] == pytest.approx([step.frame.time for step in made])
        for row, step in zip(rows, made, strict=True):
            (strip,) = row["value"]
            vertices = step.belief.regions[robot].outer.vertices
            assert np.array_equal(np.array(strip)[:-1, :2], vertices.astype(np.float32))
            assert strip[0] == strip[-1]


def test_every_inner_polygon_truth_and_estimate_is_in_the_recording(run):
    path, made = run
    inner = rows_of(path, "/world/inner/r1", "LineStrips3D:strips")
    truth = rows_of(path, "/world/truth/r1", "Points3D:positions")
    estimate = rows_of(path, "/world/estimate/r1", "Points3D:positions")
    for k, step in enumerate(made):
        region = step.belief.regions[1]
        assert np.array_equal(np.array(inner[k]["value"][0])[:-1, :2], region.inner.vertices.astype(np.float32))
        assert truth[k]["value"][0][:2] == pytest.approx(step.frame.truth.positions[1], abs=1e-6)
        assert estimate[k]["value"][0][:2] == pytest.approx(region.outer.centroid, abs=1e-6)


def test_areas_and_performance_ratios_are_plotted(run):
    path, made = run
    areas = rows_of(path, "/area/r2", "Scalars:scalars")
    ratios = rows_of(path, "/performance_ratio/r2", "Scalars:scalars")
    assert [row["value"][0] for row in areas] == [step.belief.regions[2].outer.area for step in made]
    assert [row["value"][0] for row in ratios] == [step.belief.regions[2].performance_ratio for step in made]


def test_the_fill_has_the_area_of_the_polygon(run):
    path, made = run
    corners = rows_of(path, "/world/fill/r0", "Mesh3D:vertex_positions")
    triangles = rows_of(path, "/world/fill/r0", "Mesh3D:triangle_indices")
    for step, points, indices in zip(made, corners, triangles, strict=True):
        a, b, c = (np.array(points["value"])[np.array(indices["value"])[:, k], :2] for k in range(3))
        area = np.cross(np.pad(b - a, ((0, 0), (0, 1))), np.pad(c - a, ((0, 0), (0, 1))))[:, 2].sum() / 2
        assert area == pytest.approx(step.belief.regions[0].outer.area, rel=1e-3)


def test_events_come_at_the_time_of_their_step(run):
    (event,) = rows_of(run[0], "/events", "TextLog:text")
    assert event["value"] == ["1.4 s: the end"]
    assert event["step"] == 14


def test_the_same_steps_give_the_same_recording(tmp_path):
    frames = [frame_at(0.1 * k, (Bearing(0.1 * k, [0], [2], [0.0], 0.1),)) for k in range(25)]
    one, other = (record(tmp_path / name, frames) for name in ("one.rrd", "other.rrd"))
    compared = rerun("compare", "--unordered", one, other)
    assert compared.returncode == 0, compared.stderr[-2000:]
    shifted = record(tmp_path / "shifted.rrd", [frame_at(0.1 * k) for k in range(25)])
    assert rerun("compare", "--unordered", one, shifted).returncode != 0


def test_nothing_is_lost_between_what_is_sent(tmp_path):
    times = [0.0, 0.1, 0.2, 5.0, 5.1, 6.05, 6.1]
    path = record(tmp_path / "a.rrd", [frame_at(time) for time in times])
    rows = rows_of(path, "/world/estimate/r0", "Points3D:positions")
    assert [row["t"].total_seconds() for row in rows] == times


def test_a_region_without_inner_polygon_and_a_frame_without_truth_can_be_recorded(tmp_path):
    path = record(tmp_path / "a.rrd", [frame_at(0.1 * k, truth=None) for k in range(3)])
    assert [row["value"] for row in rows_of(path, "/world/inner/r0", "LineStrips3D:strips")] == [[], [], []]
    assert not rows_of(path, "/world/truth/r0", "Points3D:positions")
    assert rerun("verify", path).returncode == 0


@pytest.mark.parametrize("arena", [[[-2, -2], [2, 2]], [[-np.inf] * 2, [np.inf] * 2]])
def test_a_team_without_walls_or_landmarks_can_be_recorded(tmp_path, arena):
    path = record(tmp_path / "a.rrd", [frame_at(0.0)], Team(2, arena=arena), np.zeros((0, 4)))
    assert rerun("verify", path).returncode == 0


def test_a_run_that_fails_leaves_a_whole_recording(tmp_path):
    path = tmp_path / "a.rrd"
    with pytest.raises(ZeroDivisionError), Recording(path, TEAM, recording_id="0", walls=WALLS, wall_height=0.3) as recording:
        recording.add(frame_at(0.0), belief_at(0.0))
        raise ZeroDivisionError
    assert rerun("verify", path).returncode == 0
    assert len(rows_of(path, "/world/outer/r0", "LineStrips3D:strips")) == 1


def test_images_are_recorded_at_their_step(tmp_path):
    path = tmp_path / "a.rrd"
    with Recording(path, TEAM, recording_id="0", walls=WALLS, wall_height=0.3, camera=True) as recording:
        for k in range(3):
            recording.add(frame_at(0.1 * k), belief_at(0.1 * k))
        recording.image(np.zeros((6, 8, 3), dtype=np.uint8))
    (image,) = rows_of(path, "/camera", "EncodedImage:media_type")
    assert (image["step"], image["value"]) == (2, ["image/jpeg"])


@pytest.mark.parametrize("truth", [True, False])
def test_a_large_team_is_recorded_layer_by_layer(tmp_path, truth):
    robots = INDIVIDUALLY + 1
    middles = np.random.default_rng(0).uniform(-9, 9, (robots, 2))
    team = Team(robots, landmarks=[[0.0, 1.0]])
    boxes = [Polygon.box(middle - 0.5, middle + 0.5 + k % 3) for k, middle in enumerate(middles)]
    belief = SetMembershipFilter(team).start(0.0, boxes, AngularIntervals.circles(robots))
    seen = Range(0.0, [0, 60], [2, 61], [1.0, 1.0], 0.1, 0.0)
    frame = Frame(0.0, None, (seen,), Truth(middles, np.zeros(robots)) if truth else None)
    path = tmp_path / "a.rrd"
    with Recording(path, team, recording_id="0", walls=WALLS, wall_height=0.3) as recording:
        recording.add(frame, belief)
    assert rerun("verify", path).returncode == 0
    outers = [region.outer for region in belief.regions]
    (strips,) = rows_of(path, "/world/outer/team", "LineStrips3D:strips")
    for strip, outer in zip(strips["value"], outers, strict=True):
        assert np.array_equal(np.array(strip)[:-1, :2], outer.vertices.astype(np.float32))
    (corners,) = rows_of(path, "/world/fill/team", "Mesh3D:vertex_positions")
    (triangles,) = rows_of(path, "/world/fill/team", "Mesh3D:triangle_indices")
    a, b, c = (np.array(corners["value"])[np.array(triangles["value"])[:, k], :2] for k in range(3))
    areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(sum(outer.area for outer in outers), rel=1e-4)
    assert [len(row["value"]) for row in rows_of(path, "/world/rays/range", "LineStrips3D:strips")] == [2]
    assert len(rows_of(path, "/world/truth/team", "Points3D:positions")) == truth
    (greatest,) = rows_of(path, "/area/greatest", "Scalars:scalars")
    assert greatest["value"] == [max(outer.area for outer in outers)]
    assert not rows_of(path, "/world/outer/r0", "LineStrips3D:strips")


def test_rays_join_who_measured_with_what_was_measured():
    records = (Bearing(0.0, [0, 1], [1, 2], [0.0, 0.0], 0.1), Range(0.0, [0], [2], [1.0], 0.1, 0.0))
    items = dict(Drawing(TEAM).items(frame_at(0.0, records), belief_at(0.0)))
    ends = [line[:, :2].tolist() for line in items["/world/rays/bearing"].lines]
    assert ends == [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 1.0]]]
    assert [line[:, :2].tolist() for line in items["/world/rays/range"].lines] == [[[0.0, 0.0], [0.0, 1.0]]]


def test_rays_of_one_step_are_gone_in_the_next():
    drawing = Drawing(TEAM)
    dict(drawing.items(frame_at(0.0, (Bearing(0.0, [0], [1], [0.0], 0.1),)), belief_at(0.0)))
    assert dict(drawing.items(frame_at(0.1), belief_at(0.1)))["/world/rays/bearing"].lines == ()


def test_a_trail_keeps_the_last_seconds_only():
    drawing = Drawing(TEAM)
    for k in range(int(TRAIL) + 5):
        truth = Truth(np.full((2, 2), float(k)), np.zeros(2))
        items = dict(drawing.items(frame_at(float(k), truth=truth), belief_at(float(k))))
    trail = items["/world/trail/r0"]
    assert isinstance(trail, Strips)
    assert trail.lines[0][:, 0].tolist() == [float(k) for k in range(4, int(TRAIL) + 5)]


def test_fifty_robots_have_fifty_colours():
    colours = [colour_of(robot) for robot in range(50)]
    assert len(set(colours)) == 50
    assert all(0 <= value <= 255 for colour in colours for value in colour)
    apart = [np.abs(np.subtract(one, other)).sum() for k, one in enumerate(colours[:12]) for other in colours[:k]]
    assert min(apart) > 40


def test_a_mixed_colour_is_between_both():
    assert mixed((0, 100, 200), (100, 100, 100), 0.5) == (50, 100, 150)
    assert mixed((1, 2, 3), (9, 9, 9), 0) == (1, 2, 3)
