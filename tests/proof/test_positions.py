"""Rows that the checker takes from a position: all that the filter makes, none that cuts off a place where the robot may be."""

import json
from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import NO_ROWS, unit
from hypothesis import given
from hypothesis import strategies as st

from experiments.logs import Header, InitialSet, LogReader, LogWriter
from experiments.proof.edges import plane
from experiments.proof.given.frame import most_of
from experiments.proof.given.log import Log
from filter import Team
from filter.linear.polytope import Polytope
from filter.sensing.rows import position_rows

seeds = st.integers(0, 2**32 - 1)
FORMS = ["fix", "wide fix", "disc", "room", "line", "lines"]


def said(rng, form, place):
    """Return a position in one of its forms that a place is in, and others that are in it, too."""
    angles, off = np.sort(rng.uniform(-np.pi, np.pi, 5)), rng.uniform(0, 1)
    around = place + rng.uniform(-1, 1, (40, 2)) * rng.choice([0.1, 10.0])
    if form == "fix":
        return {"position": (place + off * rng.choice([-1, 1], 2)).tolist(), "bound": off + 1e-9}, around
    if form == "wide fix":
        return {"position": (place + off * np.array([1, -2])).tolist(), "bound": [off + 1e-9, 2 * off + 1e-9]}, around
    if form == "disc":
        return {"position": (place + off * unit(angles[0])).tolist(), "radius": off + 1e-9}, around
    if form == "room":
        corners = place + 10 ** rng.uniform(-3, 1) * unit(angles)
        shares = rng.dirichlet(np.ones(len(corners)), 40)
        return {"vertices": corners.tolist()}, shares @ corners
    normal = 10 ** rng.uniform(-3, 3) * unit(angles[0])
    if form == "line":
        return {"normal": normal.tolist(), "offset": normal @ place + off * np.hypot(*normal)}, around
    normals = unit(angles)
    offsets = normals @ place + off
    return {"normal_x": normals[:, 0].tolist(), "normal_y": normals[:, 1].tolist(), "offset": offsets.tolist()}, around


def is_within(line, points):
    """Return which points are where a line of a log says, as nearly as floats tell."""
    if "vertices" in line:
        return np.ones(len(points), dtype=bool)
    if "normal" in line:
        return points @ line["normal"] <= line["offset"]
    if "normal_x" in line:
        return (points @ np.array([line["normal_x"], line["normal_y"]]) <= line["offset"]).all(axis=1)
    apart = points - line["position"]
    return np.hypot(*apart.T) <= line["radius"] if "radius" in line else (np.abs(apart) <= line["bound"]).all(axis=1)


@pytest.mark.parametrize("form", FORMS)
@given(seeds)
def test_its_rows_are_taken_and_nothing_that_cuts_off_a_place(tmp_path_factory, form, seed):
    rng = np.random.default_rng(seed)
    place, path = rng.uniform(-3, 3, 2) + rng.choice([0.0, 1e4, 5e6]), tmp_path_factory.getbasetemp()
    line, points = said(rng, form, place)
    with LogWriter(path / "log.jsonl", Header(Team(1), 0.0, version=2), [InitialSet(place[None])]):
        pass
    with (path / "log.jsonl").open("a") as file:
        file.write(json.dumps({"record": "position", "time": 0.5, "robot": 0, **line}) + "\n")
    (record,), (frame,) = LogReader(path / "log.jsonl").records(), Log(path).frames
    box = place - 20, place + 20
    rows = position_rows(record, Polytope(NO_ROWS, box[0][None], box[1][None]), np.zeros(len(record.robot), int))
    edges = {
        plane(sign * side): Fraction(float((sign * end) @ side))
        for side in np.eye(2)
        for sign, end in ((1, box[1]), (-1, box[0]))
    }
    places, inside = [place for place, _ in frame.places[0]], points[is_within(line, points)]
    for normal, offset in zip(rows.normal, rows.offset, strict=True):
        most = [most_of(one, plane(normal.tolist()), edges) for one in places]
        assert min(value for value in most if value is not None) <= Fraction(float(offset))
    for normal in unit(rng.uniform(-np.pi, np.pi, 20)):
        for value in (most_of(one, plane(normal.tolist()), edges) for one in places):
            assert value is None or (inside @ normal <= float(value) + 1e-8).all()
