"""Positions of antennas: runs with them are proved from the log alone, and no row that a place which they allow would break."""

import shutil
from collections import Counter
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.proved.forgeries import Forgeries, check_refused
from helpers.proved.mounted import followed, moved_by
from helpers.proved.runs import moved
from helpers.sensing.mounted import MountedWorld, turned
from helpers.worlds import unit
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.following.checks import Checks
from experiments.logs import Header, InitialSet, LogWriter
from experiments.proof.edges import WORLD, plane
from experiments.proof.exact import arc_around
from experiments.proof.given.frame import Behind, Reading, Within
from experiments.proof.given.frame import Frame as Given
from experiments.proof.given.log import Log
from experiments.proof.given.sensors import CENTRE, Mounts
from experiments.proof.measured import PLACED, Instant, of_measurement
from experiments.proof.sides import Sides
from experiments.prove import HEADINGS, LINES
from experiments.prove import prove as links_of
from filter import Frame, Position, Sensor, Team

LOG = "log.jsonl"
SENSORS = {"mast": {"position": [0.4, -0.3], "position_bound": 0.02}, "exact": {"position": [-0.2, 0.1]}}
forged = Forgeries()
seeds = st.integers(0, 2**32 - 1)


def silent(text):
    """Show nothing."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of a run in which antennas say more than anything else."""
    world = MountedWorld(np.random.default_rng(2), robots=2, landmarks=2, sloppy=0.2)
    path = tmp_path_factory.mktemp("antennas")
    return followed(path, 0, "--light", world=world, frames=3, wide=1.0, placed=0.9)


def test_any_run_is_proved(tmp_path):
    links = Counter()
    for seed in range(1, 3):
        how = {"known": seed != 2, "wide": [0.3, 2.0][seed % 2], "placed": [0.5, 1.0][seed % 2]}
        links += links_of(followed(tmp_path / str(seed), seed, "--light", **how), silent)
    assert links[PLACED] > 25


def test_far_from_the_origin_it_is_proved_as_well(tmp_path):
    world = moved_by(MountedWorld(np.random.default_rng(5), robots=2, landmarks=2), np.array([4e6, -5e6]))
    assert links_of(followed(tmp_path, 0, "--light", world=world, frames=2, placed=0.8), silent)[PLACED] > 10


def test_each_antenna_counts_as_one_measurement_also_in_one_record(tmp_path):
    team = Team(2, sensors=[Sensor("mast", [0.4, 0.0]), Sensor("twin", [0.4, 0.0])])
    sides, who, by = [1.0, -1.0, 1.0, -1.0, 1.0, 1.0], [0, 0, 0, 0, 0, 1], [0, 0, 1, 1, -1, 0]
    record = Position(0.5, who, sides, 0.0, 9.0, by)
    with LogWriter(tmp_path / LOG, Header(team, 0.0), [InitialSet(np.zeros((1, 2)))] * 2) as log:
        log.write(Frame(0.5, None, [record]))
    (frame,), counted = Log(tmp_path).frames, Checks()
    counted.measured(record)
    assert frame.measurements == counted.measurements == 4
    assert [mount.place for _, mount in frame.places[0]] == [(Fraction(0.4), 0)] * 4 + [(0, 0)]


def mounts(log, key, by):
    for sensor in log[0]["sensors"].values():
        if key == "position":
            sensor[key] = [value + by for value in sensor[key]]
        else:
            sensor[key] += by


@forged("not proved")
def antennas_elsewhere(log):
    mounts(log, "position", 0.01)


@forged("not proved")
def antennas_that_may_be_farther_off(log):
    mounts(log, "position_bound", 1e-4)


@forged("follows from nothing known")
def antennas_at_the_centres(log):
    for record in log:
        if record["record"] == "position":
            record.pop("sensor", None)


@forged("follows from nothing known")
def one_antenna_taken_for_another(log):
    for record in log:
        if record["record"] == "position" and record.get("sensor"):
            record["sensor"] = ["tag" if name == "camera" else name for name in record["sensor"]]


@forged("not proved")
def places_that_are_farther(log):
    for record in log:
        if record["record"] == "position":
            record["offset"] = [value + 1e-4 for value in record["offset"]]


@forged("was expected, not 'sonar'")
def an_antenna_that_there_is_not(log):
    for record in log:
        if record["record"] == "position":
            record["sensor"] = "sonar"


@forged("not proved")
def headings_that_are_known_less(log):
    for record in log:
        if record["record"] == "initial":
            record["heading"]["bound"] += 0.05


@forged("follows from nothing known", LINES)
def rows_that_are_nearer(lines):
    for line in lines:
        for row, source in zip(line["rows"], line["sources"], strict=True):
            if source["kind"] == "position" and source["t"] == line["t"]:
                row["offset"] = moved(row["offset"], -1e-6)


@forged("follows from nothing known", HEADINGS)
def rows_before_headings_that_are_nearer(records):
    for line in (line for record in records for line in record["lines"]):
        for row, source in zip(line["rows"], line["sources"], strict=True):
            if source["kind"] == "position":
                row["offset"] = moved(row["offset"], -1e-6)


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(folder, tmp_path, name, capsys):
    check_refused(Path(shutil.copytree(folder, tmp_path / "copy")), forged[name], capsys)


def exactly(*values):
    return [Fraction(float(value)) for value in values]


def instant(place, mount, heading, compass):
    """Return what is known of a robot: where its antenna is, how it looks by (centre, bound), and what a compass says of it."""
    reading = Reading(*exactly(*compass))
    told = Given(0.0, {("compass", 0, None): [reading]}, {0: [(place, mount)]})
    box = {plane(side): Fraction(10) for side in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))}
    log = SimpleNamespace(robots=1, landmarks=[])
    return Instant(log, told, [arc_around(*map(float, heading))], Sides(1, []), {(WORLD, 0): box})


def is_taken(then, normal, offset):
    source = {"kind": "position", "robot": 0, "target": None}
    return of_measurement(then, (WORLD, 0), source, plane(np.asarray(normal).tolist()), Fraction(float(offset))) == PLACED


@pytest.mark.parametrize("name", [None, "mast", "exact"])
@settings(max_examples=40, deadline=None)
@given(seeds)
def test_no_row_is_taken_that_cuts_off_a_centre_which_antenna_and_heading_allow(name, seed):
    """The judge draws headings in the arc and in the compass's, places of the antenna, and asks where the centre is."""
    rng = np.random.default_rng(seed)
    mount = CENTRE if name is None else Mounts(SENSORS).of(name)
    centre, half = rng.uniform(-np.pi, np.pi), rng.choice([0.0, 0.02, 0.5, 2.0, np.pi])
    compass = centre + rng.uniform(-half, half), rng.choice([0.01, 0.3, np.pi])
    low, high = max(centre - half, compass[0] - compass[1]), min(centre + half, compass[0] + compass[1])
    looks = np.append(rng.uniform(low, high, 998), [low, high])
    off = float(mount.off) * unit(rng.uniform(-np.pi, np.pi, 1000))
    arms = turned(looks, np.array([float(value) for value in mount.place]) + off)
    for place, inside in places(rng):
        then = instant(place, mount, (centre, half), compass)
        normals = unit(rng.uniform(-np.pi, np.pi, 4))
        if isinstance(place, Behind):
            own = np.array([float(value) for value in place.normal])
            normals = own[None]
        for normal in normals:
            most = ((inside[rng.integers(0, len(inside), 1000)] - arms) @ normal).max()
            assert not is_taken(then, normal, most - 1e-6)
            assert is_taken(then, normal, most + 2.0)


def places(rng):
    """Yield places of an antenna, a fix, a disc and a half-plane, with points in each."""
    middle, half = rng.uniform(-2, 2, 2), rng.uniform(0, 0.3)
    corners = middle + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    yield Within([tuple(exactly(*corner)) for corner in corners]), corners
    yield Within([tuple(exactly(*middle))], *exactly(half)), middle + half * unit(np.linspace(0, 2 * np.pi, 60))
    normal = unit(rng.uniform(-np.pi, np.pi))
    offset = float(normal @ middle)
    along = rng.uniform(-3, 3, 50)[:, None] * np.array([-normal[1], normal[0]])
    yield Behind(tuple(exactly(*normal)), *exactly(offset)), middle + along
