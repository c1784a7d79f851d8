"""Certificates made up by hand, each line of which seems to follow from the one before."""

from fractions import Fraction

import numpy as np
import pytest

from experiments.logs import Header, InitialSet, LogWriter
from experiments.proof.chain import Chain
from experiments.proof.edges import MOST
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken
from experiments.proof.shown import checked_region
from experiments.proof.sides import Sides
from filter import Frame
from filter.team import Team

LEFT, RIGHT = ([1.0, 2.0], [2.0, 3.0]), ([5.0, 6.0], [7.0, 8.0])  # where the two robots begin
ZERO = (0.0).hex()


def outcome(path, *lines):
    """Return why lines of the first step of two robots that are at rest and measure nothing are refused, or ""."""
    initial = [InitialSet(np.array([low, [high[0], low[1]], high]), (0.0, 0.1)) for low, high in (LEFT, RIGHT)]
    with LogWriter(path / "log.jsonl", Header(Team(2), 0.0, None), initial) as log:
        log.write(Frame(0.0, None, (), None))
    headings = {"centre": [ZERO] * 2, "bound": [(0.1).hex()] * 2, "lines": []}
    try:
        Chain(Log(path)).check([("headings", headings)], [(f"line {k}", line) for k, line in enumerate(lines, 1)])
    except Broken as error:
        return str(error)
    return ""


def claim(pair, normal, offset, boxes, rows=()):
    """Return a line; the boxes are lower and upper corners by robots, the rows i, j, normal and offset, all of weight 1."""
    columns = [
        {"i": i, "j": j, "normal": list(map(float.hex, n)), "offset": b.hex(), "multiplier": "0x1p+0"} for i, j, n, b in rows
    ]
    return {
        "t": ZERO,
        "version": 3,
        "from": pair[0],
        "robot": pair[1],
        "normal": list(map(float.hex, normal)),
        "offset": offset.hex(),
        "rows": columns,
        "lower": {body: low if isinstance(low, str) else list(map(float.hex, low)) for body, (low, _) in boxes.items()},
        "upper": {body: high if isinstance(high, str) else list(map(float.hex, high)) for body, (_, high) in boxes.items()},
        "sources": [{"kind": "region", "t": ZERO, "robot": 0, "target": None}] * len(rows),
    }


def test_what_the_boxes_say_of_a_pair_is_proved_and_no_more(tmp_path):
    of_two = {"0": LEFT, "1": RIGHT}
    honest = claim((0, 1), (1.0, 0.0), 6.0, of_two)
    through = claim((0, 1), (1.0, 0.0), 6.0, of_two, [(0, 1, (1.0, 0.0), 6.0)])
    assert outcome(tmp_path, honest, through) == ""
    assert "an offset that is greater by 0.1 m" in outcome(tmp_path, claim((0, 1), (1.0, 0.0), 5.9, of_two))
    forged = claim((0, 1), (1.0, 0.0), 5.9, of_two, [(0, 1, (1.0, 0.0), 5.9)])
    assert "follows from nothing known" in outcome(tmp_path, honest, forged)


@pytest.mark.parametrize("beyond", [-2, -1])
def test_no_robot_comes_before_the_first(beyond, tmp_path):
    """Counted from behind, robot -2 of two is robot 0: with its box a row that says x_1 - x_0 <= 6 would say x_1 <= 6."""
    boxes = {"1": RIGHT, str(beyond): LEFT}
    about = claim((beyond, 1), (0.0, 1.0), 8.0, boxes)
    forged = claim((-1, 1), (1.0, 0.0), 6.0, {"1": RIGHT}, [(beyond, 1, (1.0, 0.0), 6.0)])
    assert "line 1" in outcome(tmp_path, about, forged)
    assert "line 2" in outcome(tmp_path, claim((-1, 1), (0.0, 1.0), 8.0, {"1": RIGHT}), forged)


def test_a_box_is_checked_though_it_is_written_like_another(tmp_path):
    """The digits 4 and 4 for a lower corner, 9 and 9 for an upper one, or 4 and 4, 6 and 6: one text, cut in two places."""
    honest = claim((-1, 1), (1.0, 0.0), 9.0, {"1": ("44 66", "99")})
    forged = claim((-1, 1), (1.0, 0.0), 6.0, {"1": ("44", "66 99")})
    assert outcome(tmp_path, honest) == ""
    assert "box lies" in outcome(tmp_path, honest, forged)


@pytest.mark.parametrize(
    "change", [{"t": "noon"}, {"t": (0.1).hex()}, {"t": None}, {"robot": True}, {"from": -1.0}, {"rows": None}]
)
def test_a_line_of_another_form_is_no_proof(change, tmp_path):
    line = claim((-1, 0), (1.0, 0.0), 2.0, {"0": LEFT})
    assert outcome(tmp_path, line, line) == ""
    assert "line 2 (" in outcome(tmp_path, line, {**line, **change})


def test_a_side_says_no_more_than_its_line(tmp_path):
    """Robot 1 is to the right of robot 0: half a circle of directions; that it is above, too, is not so."""
    of_two = {"0": LEFT, "1": RIGHT}
    right = {**claim((0, 1), (-1.0, 0.0), 0.0, of_two), "side": 0}
    assert outcome(tmp_path, right) == ""
    beyond = {**claim((0, 1), (1.0, 0.0), 6.0, of_two), "side": 0}
    assert "a side that the target may be 6 m beyond" in outcome(tmp_path, beyond)
    for about in (1, 2, -1, None, True):
        assert "line 1" in outcome(tmp_path, {**right, "side": about})
    landmark = {**claim((-1, 1), (1.0, 0.0), 7.0, {"1": RIGHT}), "side": 2}
    assert "line 1" in outcome(tmp_path, landmark)  # there is none
    assert "line 1" in outcome(tmp_path, {**claim((0, 1), (0.0, 0.0), 0.0, of_two), "side": 0})  # a side of no direction


@pytest.mark.parametrize("place", [(2.0, 3.0), (2.0, 2.5)])
def test_of_what_may_be_in_one_place_with_the_robot_nothing_is_on_one_side(place):
    """Every line through both has it on its inner side."""
    sides, mark = Sides(1, [(Fraction(place[0]), Fraction(place[1]))]), {"from": -1, "robot": 0, "side": 1}
    line = claim((-1, 0), (1.0, 0.0), 2.0, {"0": LEFT}) | mark
    with pytest.raises(Broken, match="may be 0 m beyond"):
        sides.add(line, Fraction(2))
    sides.add(line, Fraction(2) - Fraction(1, 10**30))
    assert sides.arc(0, 1).narrow is False
    assert sides.arc(0, 1).high - sides.arc(0, 1).low < Fraction(4)


@pytest.mark.parametrize("length", [5e-324, 1e-100, 0.4, 2.1, 1e160, 1.7e308])
def test_a_normal_is_no_shorter_and_no_longer_than_floats_can_weigh(length, tmp_path):
    for normal in ((length, 0.0), (0.0, -length)):
        line = claim((-1, 0), normal, 1.0, {"0": LEFT})
        assert "a normal of length 1 was expected" in outcome(tmp_path, line | {"offset": "0x1p+1000"})


def test_a_robot_has_no_more_edges_than_can_be_compared_with_one_another(tmp_path):
    ways = np.linspace(-3, 3, MOST + 1)
    lines = [claim((-1, 0), (float(np.cos(way)), float(np.sin(way))), 20.0, {"0": LEFT}) for way in ways]
    assert outcome(tmp_path, *lines[: MOST - 4]) == ""
    assert f"more than {MOST} edges" in outcome(tmp_path, *lines)


SQUARE = {(Fraction(x), Fraction(y)): Fraction(1) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))}  # 2 m wide
CORNERS = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]


def region(corners=CORNERS, area=4.0, estimate=(0.0, 0.0)):
    """Return a region as it is shown."""
    vertices = [list(map(float.hex, corner)) for corner in corners]
    return {"vertices": vertices, "area": area.hex(), "estimate": list(map(float.hex, estimate))}


def test_a_region_is_shown_as_it_is_proved():
    shown = checked_region(region(), SQUARE)
    assert (shown.vertices, shown.area, shown.estimate) == (CORNERS, 4.0, (0, 0))
    twice = [corner for corner in CORNERS for _ in range(2)]
    assert checked_region(region(twice), SQUARE).area == 4.0


NOT_SHOWN = {
    "open": (region(), dict(list(SQUARE.items())[:3]), "no closed polygon"),
    "nothing proved": (region(), {}, "no closed polygon"),
    "smaller": (region([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0 - 1e-8), (-1.0, 1.0)]), SQUARE, "smaller"),
    "a triangle": (region(CORNERS[:3], 2.0), SQUARE, "smaller"),
    "a bow-tie": (region([CORNERS[k] for k in (0, 2, 1, 3)], 0.0), SQUARE, "an area of 0 m2 is shown of a polygon of 4 m2"),
    "a corner within": (region([*CORNERS, (-0.5, 0.0)], 3.5), SQUARE, "an area of 3.5 m2 is shown of a polygon of 4 m2"),
    "a point": (region([(0.0, 0.0)], 0.0), SQUARE, "smaller"),
    "larger": (region([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0 + 1e-8), (-1.0, 1.0)]), SQUARE, "larger"),
    "the other way round": (region(CORNERS[::-1]), SQUARE, "an area of -4 m2 is shown of a polygon of 4 m2"),
    "another area": (region(area=4.0 + 1e-7), SQUARE, "an area of 4 m2 is shown"),
    "an estimate outside": (region(estimate=(1.0 + 1e-8, 0.0)), SQUARE, "the estimate is outside"),
}


@pytest.mark.parametrize("name", NOT_SHOWN)
def test_a_region_is_shown_no_other_way(name):
    record, edges, why = NOT_SHOWN[name]
    with pytest.raises(Broken, match=why):
        checked_region(record, edges)


def test_a_region_may_be_a_point_or_a_line():
    corner = SQUARE | {(Fraction(-1), Fraction(-1)): Fraction(-2)}  # the square's upper right corner alone
    assert checked_region(region([(1.0, 1.0)] * 3, 0.0, (1.0, 1.0)), corner).area == 0.0
    diagonal = SQUARE | {(Fraction(1), Fraction(-1)): Fraction(0), (Fraction(-1), Fraction(1)): Fraction(0)}
    assert checked_region(region([CORNERS[0], CORNERS[2]], 0.0), diagonal).area == 0.0
    with pytest.raises(Broken, match="smaller"):
        checked_region(region([(1.0, 1.0)] * 3, 0.0, (1.0, 1.0)), diagonal)
