"""Certificates, and the checker that shares no code with the filter."""

import ast
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.runs import FILES, lines_of, moved, rewritten, run_of
from hypothesis import strategies as st

from experiments import prove
from experiments.moving_team import main as moving_team
from experiments.proof.line import check

ROOT = Path(__file__).parents[2]
PARTS = [path.relative_to(ROOT / "experiments").with_suffix("") for path in (ROOT / "experiments/proof").rglob("[a-z]*.py")]
CHECKER = ("prove", *(".".join(part.parts) for part in sorted(PARTS)))
seeds = st.integers(0, 2**32 - 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("proved"), light=False, steps=6)


@pytest.fixture(scope="module")
def far(tmp_path_factory):
    """Return the folder of a run so far from the origin that rounding is a million times larger."""
    return run_of(tmp_path_factory.mktemp("far"), light=False, steps=6, origin=np.full(2, 1e7))


@pytest.fixture
def copy(folder, tmp_path):
    """Return a copy of the folder, to be changed."""
    return Path(shutil.copytree(folder, tmp_path / "copy"))


@pytest.mark.parametrize("where", ["folder", "far"])
def test_a_run_is_proved_in_another_process(where, request):
    folder = request.getfixturevalue(where)
    command = [sys.executable, "-m", "experiments.prove", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    every = len(lines_of(folder)) + sum(len(record["lines"]) for record in lines_of(folder, prove.HEADINGS))
    assert f"{every} certificates proved, 0 failed" in done.stdout
    assert "headings, from bearings, too" in done.stdout
    assert "near side, over a narrower arc that is proved" in done.stdout
    assert done.stdout.splitlines()[0].split(maxsplit=1)[1].startswith("on trust: ")
    assert "rows that are edges of an earlier step, moved" in done.stdout
    assert "rows through corners of an earlier step, moved" in done.stdout
    assert "#" in done.stderr


def test_every_edge_and_every_side_has_its_line(folder):
    lines = [line for line in lines_of(folder) if "side" not in line]
    steps = len({line["t"] for line in lines})
    assert steps == 6
    assert len(lines) >= steps * 3 * (3 + 4)
    assert {(line["from"], line["robot"]) for line in lines} == {(-1, 0), (-1, 1), (-1, 2), (0, 1), (0, 2), (1, 2)}
    assert all(len(line["rows"]) == len(line["sources"]) for line in lines)
    assert all(float.fromhex(row["multiplier"]) > 0 for line in lines for row in line["rows"])


TAMPERED = {
    "the claim": (lambda line: line.update(offset=moved(line["offset"], -1e-6)), "an offset that is greater by"),
    "a row": (
        lambda line: line["rows"][0].update(offset=moved(line["rows"][0]["offset"], 1e-3)),
        "an offset that is greater by",
    ),
    "normals": (
        lambda line: [row.update(normal=[moved(part, -0.3) for part in row["normal"]]) for row in line["rows"] if row["i"] < 0],
        "an offset that is greater by",
    ),
    "a multiplier": (
        lambda line: line["rows"][0].update(multiplier=(-float.fromhex(line["rows"][0]["multiplier"])).hex()),
        "a negative multiplier",
    ),
    "a row that is left out": (lambda line: (line["rows"].pop(0), line["sources"].pop(0)), "an offset that is greater by"),
    "a source that is left out": (lambda line: line["sources"].pop(), "ValueError"),
    "the box, empty": (
        lambda line: line["upper"].update({key: [moved(v, -1e9) for v in side] for key, side in line["upper"].items()}),
        "a box without a point",
    ),
    "the box, wider": (
        lambda line: [
            line[name].update({key: [moved(v, by) for v in side] for key, side in line[name].items()})
            for name, by in (("upper", 1e9), ("lower", -1e9))
        ],
        "an offset that is greater by",
    ),
    "the box, missing": (lambda line: line.update(upper={}), "KeyError"),
    "no number": (lambda line: line.update(offset="nan"), "ValueError: cannot convert NaN"),
    "an infinite multiplier": (lambda line: line["rows"][0].update(multiplier="inf"), "OverflowError"),
    "a field": (lambda line: line.pop("rows"), "KeyError: 'rows'"),
    "no version": (lambda line: line.pop("version"), "KeyError: 'version'"),
    "another version": (lambda line: line.update(version=1), "version 1, where version 3 is read"),
    "seen from itself": (lambda line: line.update({"from": line["robot"]}), "that is none, or in the wrong order"),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_a_tampered_line_is_refused(copy, name, capsys):
    lines, (tamper, why) = lines_of(copy), TAMPERED[name]
    most = max(len(line["rows"]) for line in lines)
    loose = [k for k, line in enumerate(lines) if len(line["rows"]) == most]
    number = loose[len(loose) // 2]
    both = zip(lines[number]["rows"], lines[number]["sources"], strict=True)
    both = sorted(both, key=lambda one: -float.fromhex(one[0]["multiplier"]))  # what is tampered with matters
    lines[number].update(rows=[row for row, _ in both], sources=[source for _, source in both])
    tamper(lines[number])
    rewritten(copy, lines)
    assert prove.main([str(copy)]) == 1
    told = capsys.readouterr().out
    assert f"not proved: certificates.jsonl.gz, line {number + 1}" in told
    assert why in told


def pair_row(lines, kind):
    """Return a line, and the row of a pair in it, of the last step."""
    found = [
        (line, row)
        for line in lines
        for row, source in zip(line["rows"], line["sources"], strict=True)
        if row["i"] >= 0 and source["kind"] == kind and float.fromhex(row["multiplier"]) > 0.01
    ]
    return found[-1]


@pytest.mark.parametrize("kind", ["bearing", "range"])
def test_a_row_that_no_measurement_gives_is_refused_though_its_line_is_proved(copy, kind, capsys):
    lines = lines_of(copy)
    line, row = pair_row(lines, kind)
    row["offset"] = moved(row["offset"], -10.0)
    check(line)  # more is known than before, so the claim holds all the more
    rewritten(copy, lines)
    assert prove.main([str(copy)]) == 1
    assert "follows from nothing known" in capsys.readouterr().out


def test_what_is_known_of_a_pair_has_to_move_with_both(copy, capsys):
    lines = lines_of(copy)
    _, row = pair_row(lines, "region")
    same = [other for line in lines for other in line["rows"] if (other["i"], other["offset"]) == (row["i"], row["offset"])]
    for other in same:
        other["offset"] = moved(other["offset"], -1e-3)
    rewritten(copy, lines)
    assert prove.main([str(copy)]) == 1
    assert "follows from nothing known" in capsys.readouterr().out


def test_an_edge_that_did_not_move_with_its_robot_is_refused(copy, capsys):
    lines = lines_of(copy)
    last = lines[-1]["t"]
    for line in (line for line in lines if line["t"] == last):
        for row, source in zip(line["rows"], line["sources"], strict=True):
            if row["i"] < 0 and source["t"] != last:
                row["offset"] = moved(row["offset"], -1e-4)
    rewritten(copy, lines)
    assert prove.main([str(copy)]) == 1
    assert "follows from nothing known" in capsys.readouterr().out


def test_a_box_that_did_not_grow_is_refused(copy, capsys):
    lines = lines_of(copy)
    last = [line for line in lines if line["t"] == lines[-1]["t"]]
    robot = str(last[0]["robot"])
    last[0]["upper"][robot] = [moved(value, -1e-3) for value in last[0]["upper"][robot]]
    rewritten(copy, lines)
    assert prove.main([str(copy)]) == 1
    assert "box lies" in capsys.readouterr().out


def test_a_folder_without_certificates_is_bad_input(copy, capsys):
    (copy / prove.LINES).unlink()
    assert prove.main([str(copy)]) == 2
    assert capsys.readouterr().err.strip().endswith(f"error: {copy / prove.LINES}: No such file or directory")


@pytest.mark.parametrize(
    "name", ["log.jsonl", "summary.json", *FILES[1:], prove.ALTERNATIVES, "trajectories/r1_filter.tum", "moving_team.rrd"]
)
def test_a_run_of_which_a_file_is_not_there_is_not_proved(copy, name, capsys):
    (copy / name).unlink()
    assert prove.main([str(copy)]) == 1
    assert capsys.readouterr().out == f"not proved: {name} is not there\n"


def test_a_trajectory_of_nobody_is_no_part_of_a_run(copy, capsys):
    shutil.copy(copy / "trajectories/r1_filter.tum", copy / "trajectories/r3_filter.tum")
    assert prove.main([str(copy)]) == 1
    assert capsys.readouterr().out == "not proved: r3_filter.tum: a trajectory of a robot that there is not\n"


def test_a_run_of_which_something_was_rejected_says_so(copy, capsys):
    """Nothing in a proof can tell what was left out of it."""
    told = json.loads((copy / prove.SUMMARY).read_text())
    told.update(guarantee_in_force=False, rejected=2)
    (copy / prove.SUMMARY).write_text(json.dumps(told) + "\n")
    assert prove.main([str(copy)]) == 0
    assert "2 on trust: measurements that were rejected; the guarantee is suspended" in capsys.readouterr().out


def test_the_checker_uses_the_standard_library_alone():
    for name in CHECKER:
        source = (ROOT / f"experiments/{name.replace('.', '/')}.py").read_text()
        modules = [node.module for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)]
        modules += [alias.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Import) for alias in node.names]
        ours = {module for module in modules if module.startswith("experiments")}
        assert ours <= {f"experiments.{one}" for one in CHECKER}
        assert {module.split(".")[0] for module in set(modules) - ours} <= sys.stdlib_module_names
    assert len(CHECKER) > 8
    assert sum(len((ROOT / f"experiments/{name.replace('.', '/')}.py").read_text().splitlines()) for name in CHECKER) < 4950


def test_the_same_run_gives_the_same_certificates(tmp_path):
    files = []
    for name in ("one", "other"):
        options = ["--duration", "0.5", "--certificates", "--policy", "reject", "--seed", "3", "--out", str(tmp_path / name)]
        assert moving_team(options) == 0
        files.append([(tmp_path / name / file).read_bytes() for file in FILES])
    assert files[0] == files[1]
    assert prove.main([str(tmp_path / "one")]) == 0
