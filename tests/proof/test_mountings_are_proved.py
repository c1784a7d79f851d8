"""Sensors that are mounted somewhere: what the filter makes of what they say is proved, and nothing that they do not say."""

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.forgeries import Forgeries, check_refused
from helpers.proved.mounted import followed, moved_by
from helpers.proved.runs import moved
from helpers.sensing.mounted import MountedWorld

from experiments.prove import HEADINGS, LINES
from experiments.prove import prove as links_of

LOG = "log.jsonl"
NARROW, WIDE = 0.02, 0.2  # sets in the beginning: of small ones nothing is found case by case [m]
forged = Forgeries()


def silent(text):
    """Show nothing."""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Return the folders of runs that begin with small sets, and with larger ones."""
    path, found = tmp_path_factory.mktemp("mounted"), {}
    for wide in (NARROW, WIDE):
        world = MountedWorld(np.random.default_rng(2), robots=2, landmarks=2)
        found[wide] = followed(path / str(wide), 0, "--light", world=world, frames=3, wide=wide)
    return found


def test_any_run_is_proved(tmp_path):
    links = Counter()
    for seed in range(3):
        how = {"known": seed != 2, "wide": [0.3, 2.0][seed % 2], "mates": seed > 0}
        links += links_of(followed(tmp_path / str(seed), seed, "--light", **how), silent)
    assert links["rows of bearings, from the log"] > 40
    assert links["rows of ranges, near side, over a narrower arc that is proved"] > 20
    assert links["headings, from bearings, too"] > 2
    assert links["robots, case by case"] > 10


def test_far_from_the_origin_it_is_proved_as_well(tmp_path):
    world = moved_by(MountedWorld(np.random.default_rng(5), robots=2, landmarks=2), np.array([4e6, -5e6]))
    links = links_of(followed(tmp_path, 0, "--light", world=world, frames=3, wide=0.1), silent)
    assert links["rows of bearings, from the log"] > 0
    assert links["rows of ranges, near side, over a narrower arc that is proved"] > 0


def all_of(log, *kinds):
    return [record for record in log if record["record"] in kinds]


@forged("a side that the target may be")
def a_camera_farther_ahead(log):
    for sensor in log[0]["sensors"].values():
        sensor["position"][0] += 1e-3


@forged("in one of the cases")
def a_camera_that_may_be_farther_off(log):
    for sensor in log[0]["sensors"].values():
        sensor["position_bound"] += 1e-5


@forged("is not proved")
def a_camera_that_looks_elsewhere(log):
    log[0]["sensors"]["camera"]["angle"] += 0.05


@forged("the heading of robot 0 is not proved")
def a_camera_that_may_look_elsewhere(log):
    log[0]["sensors"]["camera"]["angle_bound"] += 1e-3


@forged("the heading of robot 0 is not proved")
def a_compass_that_may_be_turned(log):
    log[0]["sensors"]["compass"]["angle_bound"] += 1e-3


@forged("the heading of robot 1 is not proved")
def sensors_exchanged(log):
    other = {"camera": "tag", "tag": "camera"}
    for record in (record for record in all_of(log, "bearing", "range") if "sensor" in record):
        record["sensor"] = [other.get(name, name) for name in record["sensor"]]


@forged("the heading of robot 1 is not proved")
def sensors_at_the_centres(log):
    for record in all_of(log, "bearing", "range"):
        record.pop("sensor", None)


@forged("a row on (0, 1) follows from nothing known")
def tags_at_the_centres(log):
    for record in all_of(log, "bearing", "range"):
        record.pop("target_sensor", None)


@forged("in one of the cases", run=WIDE)
def a_heading_that_is_wider(log):
    for record in all_of(log, "initial"):
        record["heading"]["bound"] += 1e-3


@forged("was expected, not 'camera'")
def a_sensor_that_there_is_not(log):
    log[0]["sensors"]["sonar"] = log[0]["sensors"].pop("camera")


@forged("landmarks are where they are")
def a_tag_on_a_landmark(log):
    for record in all_of(log, "range"):
        record["target_sensor"] = ["tag"] * len(record["robot"])


@forged("a side that the target may be", HEADINGS)
def sides_of_the_centres(lines):
    for line in (line for record in lines for line in record["lines"]):
        line.pop("sensors", None)


@forged("a side that the target may be", HEADINGS)
def sides_of_other_sensors(lines):
    for line in (line for record in lines for line in record["lines"]):
        if "sensors" in line:
            line["sensors"][0] = 1 if line["sensors"][0] < 1 else 0


@forged("follows from nothing known", LINES)
def rows_that_are_nearer(lines):
    for line in lines:
        for row, source in zip(line["rows"], line["sources"], strict=True):
            if source["kind"] in ("bearing", "range") and source["t"] == line["t"]:
                row["offset"] = moved(row["offset"], -1e-6)


@forged("the heading of robot 0 is not proved", HEADINGS)
def headings_that_are_narrower(lines):
    for line in lines:
        line["bound"] = [moved(bound, -1e-9) for bound in line["bound"]]


@forged("can be beyond what is claimed", HEADINGS, run=WIDE)
def cells_that_are_smaller(lines):
    for line in (line for record in lines for line in record["lines"]):
        for claim in line.get("claims", ()):
            claim["offset"] = moved(claim["offset"], -1e-3)


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(folders, tmp_path, name, capsys):
    copy = Path(shutil.copytree(folders[forged[name].run or NARROW], tmp_path / "copy"))
    check_refused(copy, forged[name], capsys)
