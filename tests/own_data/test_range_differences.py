"""Differences of ranges in recordings: in the log they are positions that hold every place with such a difference."""

import json

import numpy as np
import pytest
from helpers.own_data.settings_files import OF_TABLES, of_robots

from experiments.convert import main
from experiments.following.scenarios import from_log
from experiments.following.steps import steps
from experiments.show.command import BAD_INPUT
from filter import SetMembershipFilter

MARKS = {"gate": [1.0, 2.0], "north": [-8.0, 9.0], "south": [0.0, -9.5], "east": [9.0, 0.5]}
HEAD = OF_TABLES.replace("gate = [1.0, 2.0]", ", ".join(f"{name} = {place}" for name, place in MARKS.items()))
STREAM = 'file = "tdoa.csv", bound = 0.1'
BOUND = 0.1


@pytest.fixture
def converted(tmp_path, capsys):
    """Return a function that converts a table of differences; it returns exit code, positions, and what was told."""

    def converted(lines, stream=STREAM, head=HEAD):
        (tmp_path / "data").mkdir(exist_ok=True)
        (tmp_path / "data" / "tdoa.csv").write_text("\n".join(lines) + "\n")
        (tmp_path / "my.toml").write_text(of_robots(head, range_difference=stream))
        code = main([str(tmp_path / "my.toml"), str(tmp_path / "data"), str(tmp_path / "out.jsonl")])
        out = tmp_path / "out.jsonl"
        records = [json.loads(line) for line in out.read_text().splitlines()][3:] if out.exists() else []
        return code, records, capsys.readouterr().err

    return converted


def difference(points, first, second):
    """Return how much farther (..., 2) points are from one landmark than from another."""
    return np.hypot(*np.moveaxis(points - np.array(MARKS[first]), -1, 0)) - np.hypot(
        *np.moveaxis(points - np.array(MARKS[second]), -1, 0)
    )


def holds(record, points):
    """Return (k,) whether (k, 2) points are in all half-planes of a record, to a nanometre."""
    normals = np.stack([record["normal_x"], record["normal_y"]], axis=1)
    return (points @ normals.T <= np.array(record["offset"]) + 1e-9).all(axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_it_holds_every_place_of_the_arena_with_such_a_difference(converted, seed):
    """Held against a grid; truths are anywhere, also in corners, and errors at their bounds."""
    rng = np.random.default_rng(seed)
    truths = rng.uniform(-10, 10, (12, 2))
    truths[:4] = [[-10, -10], [10, 10], [10, -10], [-10, 10]]
    pairs = [rng.choice(list(MARKS), 2, replace=False).tolist() for _ in truths]
    measured = [float(difference(p, *pair) + rng.choice([-1, 0, 1]) * BOUND) for p, pair in zip(truths, pairs, strict=True)]
    rows = [f"{k},{value!r},{a},{b}" for k, (value, (a, b)) in enumerate(zip(measured, pairs, strict=True))]
    code, records, _ = converted(["t,difference,first,second", *rows])
    assert code == 0
    grid = np.stack(np.meshgrid(*[np.linspace(-10, 10, 81)] * 2), axis=-1).reshape(-1, 2)
    for record in records:
        k = int(record["time"])
        assert holds(record, truths[[k]]).all()
        possible = np.abs(difference(grid, *pairs[k]) - measured[k]) <= BOUND
        assert holds(record, grid[possible]).all()


def test_a_pair_of_bounds_units_and_ids_are_as_in_other_streams(converted):
    truth = np.array([3.0, -4.0])
    value = float(difference(truth, "north", "gate"))
    stream = 'file = "tdoa.csv", difference = "mm", first = "a", second = "b", unit = "millimetres", ids = { 5 = "north" }'
    code, records, _ = converted(["t,mm,a,b", f"1,{1e3 * (value + 0.3)!r}, 5 ,gate"], f"{stream}, bound = [0.0, 300.0]")
    assert code == 0
    assert holds(records[0], truth[None]).all()
    code, records, _ = converted(["t,mm,a,b", f"1,{1e3 * (value + 0.3)!r},5,gate"], f"{stream}, bound = [-1300.0, -1000.0]")
    assert not holds(records[0], truth[None]).any(), "measured - true is not within [-1.3, -1.0]"


def test_settings_can_name_the_two_landmarks(converted):
    truth = np.array([3.0, -4.0])
    row = f"1,{float(difference(truth, 'north', 'gate'))!r}"
    code, records, _ = converted(["t,difference", row], STREAM + ', landmarks = ["north", "gate"]')
    assert code == 0
    assert holds(records[0], truth[None]).all()
    code, turned, _ = converted(["t,difference", row], STREAM + ', landmarks = ["gate", "north"]')
    assert code == 0
    assert not holds(turned[0], truth[None]).any(), "the branch turns with the landmarks"


def test_an_antenna_may_be_out_of_the_arena(converted):
    """The robot's centre is in a corner, and its antenna a metre beyond it, a centimetre farther than said."""
    antenna = np.array([10.0, 10.0]) + 1.01 * np.array([np.cos(0.7), np.sin(0.7)])
    head = HEAD.replace("speed_limit", "sensors = { uwb = { position = [1.0, 0.0], position_bound = 0.01 } }\nspeed_limit", 1)
    for first, second in (("gate", "north"), ("south", "gate"), ("east", "north"), ("north", "south")):
        value = float(difference(antenna, first, second))
        stream = f'{STREAM}, sensor = "uwb", landmarks = ["{first}", "{second}"]'
        code, records, _ = converted(["t,difference", f"1,{value!r}"], stream, head)
        assert code == 0
        assert records[0]["sensor"] == "uwb"
        assert holds(records[0], antenna[None]).all()


def test_three_landmarks_find_a_robot_in_a_log(converted, tmp_path):
    truth, rng = np.array([3.0, -4.0]), np.random.default_rng(0)
    pairs = [("north", "south"), ("south", "east"), ("east", "north"), ("gate", "north")]
    rows = [
        f"{k},{float(difference(truth, *pair)) + BOUND * rng.uniform(-1, 1)!r},{pair[0]},{pair[1]}"
        for k in range(6)
        for pair in pairs
    ]
    head = HEAD.replace("speed_limit = 1.0", "speed_limit = 0.01")
    assert converted(["t,difference,first,second", *rows], head=head)[0] == 0
    scenario = from_log(tmp_path / "out.jsonl")
    *_, last = steps(SetMembershipFilter(scenario.team), scenario)
    assert last.belief.regions[0].outer.contains(truth)
    assert last.belief.regions[0].outer.area < 1.0


def test_what_says_nothing_is_left_out_and_why_is_told(converted):
    rows = ["1,1.0,gate,west", "2,1.0,gate,b", "3,1.0,gate,gate", "4,,gate,north", "5,1.0,gate,north", "6,1.0,north,gate"]
    code, records, told = converted(["t,difference,first,second", *rows])
    assert (code, [record["time"] for record in records]) == (0, [5.0, 6.0])
    for why in ('called "west"', "b is no landmark whose place is known", "it names one place twice", "nothing in difference"):
        assert why in told
    code, records, told = converted(["t,difference,first,second", *rows], 'file = "tdoa.csv", bound = 50')
    assert code == BAD_INPUT
    assert "its difference excludes nothing of the arena" in told or "data that records can be made of" in told


ONE = ["t,difference,first,second", "1,1.0,gate,north"]


@pytest.mark.parametrize(
    ("stream", "told"),
    [
        ('file = "tdoa.csv"', "without a bound there is no guarantee"),
        (STREAM + ', landmarks = ["gate", "nort"]', 'did you mean "north"'),
        (STREAM + ', landmarks = ["gate", "b"]', "landmarks: names whose places are known"),
        (STREAM + ', landmarks = ["gate", "gate"]', "the names of two [first, second]"),
        (STREAM + ', landmarks = ["gate"]', "the names of two [first, second]"),
        (STREAM + ', landmarks = ["gate", "north"], first = "first"', "said once"),
        (STREAM + ', target = "gate"', "keys that are known"),
        (STREAM + ', sensor = "uwb"', "a name in [team.sensors]"),
        (STREAM.replace("tdoa", "{target}"), "is of nobody else"),
        ('file = "tdoa.csv", bound = [0.1, -0.1]', "low first"),
    ],
)
def test_a_slip_is_told(converted, stream, told):
    code, _, said = converted(ONE, stream)
    assert code == BAD_INPUT
    assert told in said


def test_an_arena_without_end_is_told_and_so_is_a_landmark_known_only_roughly(converted):
    code, _, said = converted(ONE, head=HEAD.replace("[10, 10]]", "[10, inf]]"))
    assert code == BAD_INPUT
    assert "without open ends" in said
    rough = HEAD.replace("gate = [1.0, 2.0]", "gate = { position = [1.0, 2.0], bound = 0.1 }")
    code, _, said = converted([*ONE, "2,1.0,north,east"], head=rough)
    assert code == 0
    assert "gate is no landmark whose place is known" in said
