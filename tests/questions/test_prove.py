"""Certificates, and the checker that shares no code with the filter."""

import ast
import gzip
import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from helpers.worlds import World, unit
from hypothesis import given
from hypothesis import strategies as st

from experiments import prove
from experiments.logs import Certificates, Header, InitialSet, LogWriter
from experiments.logs.certificates import hexadecimal
from experiments.moving_team import main as moving_team
from experiments.proof.chain import plane, through_corner
from experiments.proof.exact import PI, Arc, Motion, length, sector
from experiments.proof.exact import unit as enclosed
from filter import AngularIntervals, Frame, Odometry, Polygon, SetMembershipFilter, Team, follow
from filter.sensing.motion import displacements

ROOT = Path(__file__).parents[2]
CHECKER = ("prove", "proof.chain", "proof.log", "proof.exact")
seeds = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module", params=[0.0, 1e7], ids=["near", "far"])
def folder(request, tmp_path_factory):
    """Return the folder of a run of 8 steps, some of them backwards, one robot now and then without odometry."""
    path = tmp_path_factory.mktemp("proved")
    world = World(np.random.default_rng(0), robots=3, errors="extreme", origin=np.full(2, request.param))
    estimator = SetMembershipFilter(world.team)
    sets, arcs = world.initial_sets(), world.initial_headings()
    known = [(float(c), float(b)) for c, b in zip(arcs.centre, arcs.bound, strict=True)]
    initial = [InitialSet(one.vertices, heading) for one, heading in zip(sets, known, strict=True)]
    belief = estimator.start(0.0, [one.polygon() for one in initial], arcs)
    with LogWriter(path / "log.jsonl", Header(world.team, 0.0, None), initial) as log, Certificates(path) as file:
        for k in range(8):
            motion = world.move(backwards=k % 2 == 1) if k else None
            if motion is not None and k % 3 == 0:
                columns = {
                    name: getattr(motion, name)[1:] for name in Odometry.__dataclass_fields__ if name not in ("start", "time")
                }
                motion = Odometry(motion.start, motion.time, **columns)
            frame = Frame(world.time, motion, tuple(world.measure()))
            log.write(frame)
            belief = next(follow(estimator, belief, [frame])).belief
            file.write(belief)
    return path


def lines_of(folder):
    return [json.loads(line) for line in gzip.open(folder / prove.FILE, "rt").read().splitlines()]


def proved(folder, lines, tmp_path, *others):
    """Return the exit code for other lines, with the files beside them that are named."""
    for name in others:
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    with gzip.open(tmp_path / prove.FILE, "wt") as file:
        file.writelines(json.dumps(line) + "\n" for line in lines)
    return prove.main([str(tmp_path)])


def moved(text, by):
    return (float.fromhex(text) + by).hex()


def test_a_run_is_proved_in_another_process(folder):
    command = [sys.executable, "-m", "experiments.prove", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert f"{len(lines_of(folder))} certificates proved, 0 failed" in done.stdout
    assert "rows that are edges of an earlier step, moved" in done.stdout
    assert "rows through corners of an earlier step, moved" in done.stdout
    assert "#" in done.stderr


def test_every_edge_and_every_side_has_its_line(folder):
    lines = lines_of(folder)
    steps = len({line["t"] for line in lines})
    assert steps == 8
    assert len(lines) >= steps * 3 * (3 + 4)
    assert {(line["from"], line["robot"]) for line in lines} == {(-1, 0), (-1, 1), (-1, 2), (0, 1), (0, 2), (1, 2)}
    assert all(len(line["rows"]) == len(line["sources"]) for line in lines)
    assert all(float.fromhex(row["multiplier"]) > 0 for line in lines for row in line["rows"])


TAMPERED = {
    "the claim": lambda line: line.update(offset=moved(line["offset"], -1e-6)),
    "the claim, next to nothing": lambda line: line.update(offset=moved(line["offset"], -1e-5)),
    "a row": lambda line: line["rows"][0].update(offset=moved(line["rows"][0]["offset"], 1e-3)),
    "normals": lambda line: [
        row.update(normal=[moved(part, -0.3) for part in row["normal"]]) for row in line["rows"] if row["i"] < 0
    ],
    "a multiplier": lambda line: line["rows"][0].update(multiplier=(-float.fromhex(line["rows"][0]["multiplier"])).hex()),
    "a row that is left out": lambda line: (line["rows"].pop(0), line["sources"].pop(0)),
    "the box, empty": lambda line: line["upper"].update(
        {key: [moved(v, -1e9) for v in side] for key, side in line["upper"].items()}
    ),
    "the box, wider": lambda line: [
        line[name].update({key: [moved(v, by) for v in side] for key, side in line[name].items()})
        for name, by in (("upper", 1e9), ("lower", -1e9))
    ],
    "the box, missing": lambda line: line.update(upper={}),
    "no number": lambda line: line.update(offset="nan"),
    "an infinite multiplier": lambda line: line["rows"][0].update(multiplier="inf"),
    "a field": lambda line: line.pop("rows"),
    "no version": lambda line: line.pop("version"),
    "another version": lambda line: line.update(version=2),
    "seen from itself": lambda line: line.update({"from": line["robot"]}),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_a_tampered_line_is_refused(folder, name, tmp_path, capsys):
    lines = lines_of(folder)
    most = max(len(line["rows"]) for line in lines)
    loose = [k for k, line in enumerate(lines) if len(line["rows"]) == most]
    line = lines[loose[len(loose) // 2]]
    line["rows"].sort(key=lambda row: -float.fromhex(row["multiplier"]))  # what is tampered with matters
    TAMPERED[name](line)
    assert proved(folder, [line], tmp_path) == 1
    assert "not proved: line 1" in capsys.readouterr().out


def pair_row(lines, kind):
    """Return a line, the row of a pair in it, and its source, of the last step."""
    found = [
        (line, row, source)
        for line in lines
        for row, source in zip(line["rows"], line["sources"], strict=True)
        if row["i"] >= 0 and source["kind"] == kind and float.fromhex(row["multiplier"]) > 0.01
    ]
    return found[-1]


@pytest.mark.parametrize("kind", ["bearing", "range"])
def test_a_row_that_no_measurement_gives_is_refused_though_its_line_is_proved(folder, kind, tmp_path, capsys):
    lines = lines_of(folder)
    line, row, _ = pair_row(lines, kind)
    row["offset"] = moved(row["offset"], -10.0)
    alone = {**line, "offset": moved(line["offset"], 0.0)}
    prove.check(alone)  # more is known than before, so the claim holds all the more
    assert proved(folder, lines, tmp_path, "log.jsonl", "headings.jsonl.gz") == 1
    assert "follows from nothing known" in capsys.readouterr().out


def test_what_is_known_of_a_pair_has_to_move_with_both(folder, tmp_path, capsys):
    lines = lines_of(folder)
    _, row, _ = pair_row(lines, "region")
    same = [other for line in lines for other in line["rows"] if (other["i"], other["offset"]) == (row["i"], row["offset"])]
    for other in same:
        other["offset"] = moved(other["offset"], -1e-3)
    assert proved(folder, lines, tmp_path, "log.jsonl", "headings.jsonl.gz") == 1
    assert "follows from nothing known" in capsys.readouterr().out


@given(seeds, st.sampled_from([0.0, 1e6]))
def test_a_row_through_a_corner_is_proved_by_the_edges_beside_it_and_no_smaller_one_is(seed, origin):
    rng = np.random.default_rng(seed)
    polygon = Polygon.from_vertices(origin + rng.normal(size=(9, 2)))
    edges = {plane(hexadecimal(n)): Fraction(float(b)) for n, b in zip(polygon.normals, polygon.offsets, strict=True)}
    normal = unit(rng.uniform(-np.pi, np.pi))
    found = through_corner(edges, plane(hexadecimal(normal)))
    assert float(found) == pytest.approx((polygon.vertices @ normal).max(), abs=1e-9 + 1e-8 * origin)


def test_no_corner_is_beyond_all_edges():
    edges = {plane(hexadecimal(unit(np.radians(angle)))): Fraction(1) for angle in (0.0, 60.0)}
    assert through_corner(edges, plane(hexadecimal(unit(np.radians(200.0))))) is None
    assert through_corner({}, plane(hexadecimal(unit(1.0)))) is None


def test_an_edge_that_did_not_move_with_its_robot_is_refused(folder, tmp_path, capsys):
    lines = lines_of(folder)
    last = lines[-1]["t"]
    for line in (line for line in lines if line["t"] == last):
        for row, source in zip(line["rows"], line["sources"], strict=True):
            if row["i"] < 0 and source["t"] != last:
                row["offset"] = moved(row["offset"], -1e-4)
    assert proved(folder, lines, tmp_path, "log.jsonl", "headings.jsonl.gz") == 1
    assert "not proved: " in capsys.readouterr().out


def test_a_box_that_did_not_grow_is_refused(folder, tmp_path, capsys):
    lines = lines_of(folder)
    last = [line for line in lines if line["t"] == lines[-1]["t"]]
    robot = str(last[0]["robot"])
    last[0]["upper"][robot] = [moved(value, -1e-3) for value in last[0]["upper"][robot]]
    assert proved(folder, lines, tmp_path, "log.jsonl", "headings.jsonl.gz") == 1
    assert "box lies" in capsys.readouterr().out


def test_a_step_that_is_missing_is_noticed(folder, tmp_path, capsys):
    lines = lines_of(folder)
    kept = [line for line in lines if line["t"] != lines[len(lines) // 2]["t"]]
    assert proved(folder, kept, tmp_path, "log.jsonl", "headings.jsonl.gz") == 1
    assert "another frame" in capsys.readouterr().out


def test_without_the_log_it_says_what_it_takes_on_trust(folder, tmp_path, capsys):
    assert proved(folder, lines_of(folder), tmp_path) == 0
    assert "on trust: where the rows come from" in capsys.readouterr().out


def test_what_cannot_be_read_is_no_proof(tmp_path, folder, capsys):
    assert prove.main([str(tmp_path)]) == 2
    assert prove.FILE in capsys.readouterr().err
    assert proved(folder, [], tmp_path) == 1
    packed = (folder / prove.FILE).read_bytes()
    for damaged in (packed[: len(packed) // 2], b"no gzip"):
        (tmp_path / prove.FILE).write_bytes(damaged)
        assert prove.main([str(tmp_path)]) == 1


def test_the_checker_uses_the_standard_library_alone():
    for name in CHECKER:
        source = (ROOT / f"experiments/{name.replace('.', '/')}.py").read_text()
        modules = [node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)]
        modules += [alias.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Import) for alias in node.names]
        ours = {module for module in modules if module.startswith("experiments")}
        assert ours <= {f"experiments.{one}" for one in CHECKER}
        assert {module.split(".")[0] for module in set(modules) - ours} <= sys.stdlib_module_names
    assert len((ROOT / "experiments/prove.py").read_text().splitlines()) < 170


def test_the_same_run_gives_the_same_certificates(tmp_path):
    files = []
    for name in ("one", "other"):
        options = ["--duration", "0.5", "--certificates", "--policy", "reject", "--seed", "3", "--out", str(tmp_path / name)]
        assert moving_team(options) == 0
        assert prove.main([str(tmp_path / name)]) == 0
        files.append([(tmp_path / name / file).read_bytes() for file in (prove.FILE, "headings.jsonl.gz")])
    assert files[0] == files[1]


@given(st.floats(-50, 50))
def test_sines_and_cosines_are_enclosed(angle):
    (low, high), (least, greatest) = enclosed(Fraction(angle))
    assert high - low == greatest - least == Fraction(3, 2**110)
    assert abs(float(low) - np.cos(angle)) < 1e-15
    assert abs(float(least) - np.sin(angle)) < 1e-15
    squares = [(min(a * a, b * b), max(a * a, b * b)) for a, b in ((low, high), (least, greatest))]
    assert squares[0][0] + squares[1][0] <= 1 <= squares[0][1] + squares[1][1]


def test_the_angles_of_a_triangle_are_known():
    sixty, thirty = enclosed(PI / 3), enclosed(PI / 6)
    assert sixty[0][0] < Fraction(1, 2) < sixty[0][1]
    assert thirty[1][0] < Fraction(1, 2) < thirty[1][1]
    assert length((Fraction(3), Fraction(4))) - 5 < Fraction(1, 2**100)


@given(seeds)
def test_a_displacement_is_within_its_support_and_the_filter_claims_no_less(seed):
    rng = np.random.default_rng(seed)
    heading, bound, turn, turned, skew = rng.uniform(-np.pi, np.pi), rng.uniform(0, 0.4), *rng.uniform(0, 0.3, 3)
    way, error, slip = rng.uniform(-1, 1), rng.uniform(0, 0.5), rng.uniform(0, 0.1)
    arc = Arc(Fraction(heading) - Fraction(bound), Fraction(heading) + Fraction(bound))
    arc = arc.widened(Fraction(turn) / 2, Fraction(turned) / 2 + Fraction(skew))
    bend = (Fraction(turn) + Fraction(turned)) / 2 + Fraction(skew)
    motion = Motion(arc, Fraction(way) - Fraction(error), Fraction(way) + Fraction(error), bend, Fraction(slip))
    odometry = Odometry(0.0, 1.0, 0, way, error, turn, turned, skew, slip)
    moves = displacements(odometry, AngularIntervals([heading], [bound]), Team(1), 1.0)
    for angle in rng.uniform(-np.pi, np.pi, 4):
        normal = unit(angle)
        x, y = (Fraction(float(value)) for value in normal)
        support = motion.support((x, y))
        assert support <= Fraction(float(moves.support(np.array([0]), normal[None])[0]))
        for _ in range(8):
            far = Fraction(float(rng.uniform(way - error, way + error)))
            u = enclosed(arc.low + (arc.high - arc.low) * Fraction(float(rng.uniform())))
            along = far * (x * u[0][0] + y * u[1][0]) + Fraction(slip) * length((x, y))
            assert along - Fraction(1, 10**12) <= support


def test_a_sector_reaches_as_far_as_its_corners_and_its_rim():
    arc = Arc(Fraction(-1, 2), Fraction(1, 2))
    assert sector((Fraction(1), Fraction(0)), arc, Fraction(1), Fraction(2)) == pytest.approx(2, abs=1e-12)
    assert sector((Fraction(-1), Fraction(0)), arc, Fraction(1), Fraction(2)) == pytest.approx(-np.cos(0.5), abs=1e-12)
    assert sector((Fraction(0), Fraction(1)), arc, Fraction(1), Fraction(2)) == pytest.approx(2 * np.sin(0.5), abs=1e-12)
