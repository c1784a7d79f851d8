"""Certificates made up by hand, each line of which seems to follow from the one before."""

import gzip
import json

import numpy as np
import pytest

from experiments import prove
from experiments.logs import Header, InitialSet, LogWriter
from experiments.logs.certificates import HEADINGS, hexadecimal
from filter.measurements import Frame
from filter.team import Team

LEFT, RIGHT = ([1.0, 2.0], [2.0, 3.0]), ([5.0, 6.0], [7.0, 8.0])  # where the two robots begin
ZERO = (0.0).hex()


def outcome(path, *lines):
    """Return the exit code for lines of the first step of two robots that are at rest and measure nothing."""
    initial = [InitialSet(np.array([low, [high[0], low[1]], high]), (0.0, 0.1)) for low, high in (LEFT, RIGHT)]
    with LogWriter(path / "log.jsonl", Header(Team(2), 0.0, None), initial) as log:
        log.write(Frame(0.0, None, (), None))
    with gzip.open(path / HEADINGS, "wt") as file:
        file.write(json.dumps({"t": ZERO, "centre": hexadecimal(np.zeros(2)), "bound": hexadecimal(np.full(2, 0.1))}))
    with gzip.open(path / prove.FILE, "wt") as file:
        file.writelines(json.dumps(line) + "\n" for line in lines)
    return prove.main([str(path)])


def claim(pair, normal, offset, boxes, rows=()):
    """Return a line; the boxes are lower and upper corners by robots, the rows i, j, normal and offset, all of weight 1."""
    columns = [
        {"i": i, "j": j, "normal": list(map(float.hex, n)), "offset": b.hex(), "multiplier": "0x1p+0"} for i, j, n, b in rows
    ]
    return {
        "t": ZERO,
        "version": 1,
        "from": pair[0],
        "robot": pair[1],
        "normal": list(map(float.hex, normal)),
        "offset": offset.hex(),
        "rows": columns,
        "lower": {body: low if isinstance(low, str) else list(map(float.hex, low)) for body, (low, _) in boxes.items()},
        "upper": {body: high if isinstance(high, str) else list(map(float.hex, high)) for body, (_, high) in boxes.items()},
        "sources": [{"kind": "region", "t": ZERO, "robot": 0, "target": None}] * len(rows),
    }


def test_what_the_boxes_say_of_a_pair_is_proved_and_no_more(tmp_path, capsys):
    of_two = {"0": LEFT, "1": RIGHT}
    honest = claim((0, 1), (1.0, 0.0), 6.0, of_two)
    through = claim((0, 1), (1.0, 0.0), 6.0, of_two, [(0, 1, (1.0, 0.0), 6.0)])
    assert outcome(tmp_path, honest, through) == 0
    assert outcome(tmp_path, claim((0, 1), (1.0, 0.0), 5.9, of_two)) == 1
    assert outcome(tmp_path, honest, claim((0, 1), (1.0, 0.0), 5.9, of_two, [(0, 1, (1.0, 0.0), 5.9)])) == 1
    assert "follows from nothing known" in capsys.readouterr().out


@pytest.mark.parametrize("beyond", [-2, -1])
def test_no_robot_comes_before_the_first(beyond, tmp_path, capsys):
    """Counted from behind, robot -2 of two is robot 0: with its box a row that says x_1 - x_0 <= 6 would say x_1 <= 6."""
    boxes = {"1": RIGHT, str(beyond): LEFT}
    about = claim((beyond, 1), (0.0, 1.0), 8.0, boxes)
    forged = claim((-1, 1), (1.0, 0.0), 6.0, {"1": RIGHT}, [(beyond, 1, (1.0, 0.0), 6.0)])
    assert outcome(tmp_path, about, forged) == 1
    assert "not proved" in capsys.readouterr().out
    assert outcome(tmp_path, claim((-1, 1), (0.0, 1.0), 8.0, {"1": RIGHT}), forged) == 1


def test_a_box_is_checked_though_it_is_written_like_another(tmp_path, capsys):
    """The digits 4 and 4 for a lower corner, 9 and 9 for an upper one, or 4 and 4, 6 and 6: one text, cut in two places."""
    honest = claim((-1, 1), (1.0, 0.0), 9.0, {"1": ("44 66", "99")})
    forged = claim((-1, 1), (1.0, 0.0), 6.0, {"1": ("44", "66 99")})
    assert outcome(tmp_path, honest) == 0
    assert outcome(tmp_path, honest, forged) == 1
    assert "box lies" in capsys.readouterr().out


@pytest.mark.parametrize("wrong", [{}, [1], "x", 3, None, {"t": ZERO, "robot": 0}])
def test_a_line_of_another_form_is_no_proof(wrong, tmp_path, capsys):
    line = claim((-1, 0), (1.0, 0.0), 2.0, {"0": LEFT})
    assert outcome(tmp_path, line, line) == 0
    for lines in (
        [wrong],
        [line, wrong],
        [line, {**line, "t": "noon"}],
        [line, {key: line[key] for key in line if key != "t"}],
    ):
        assert outcome(tmp_path, *lines) == 1
        assert f"not proved: line {len(lines)} (" in capsys.readouterr().out
