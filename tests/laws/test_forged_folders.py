"""Folders of a run in which something was forged or cut: each is refused, for the reason that was expected."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.runs import lines_of, moved, rewritten, run_of

from experiments import prove
from experiments.prove import HEADINGS, LINES, REGIONS, SUMMARY

LOG, FIRST, TUM = "log.jsonl", "trajectories/r0_filter.tum", "trajectories/r2_filter.tum"
FORGED = {}


def forged(why, name=LINES):
    """Enter a function that changes the records of a file in place, or returns others, with the reason of the refusal."""

    def entered(change):
        FORGED[change.__name__] = (name, change, why)
        return change

    return entered


def times(lines):
    return list(dict.fromkeys(line["t"] for line in lines))


def of_last(lines):
    return [line for line in lines if line["t"] == lines[-1]["t"]]


def all_of(log, kind):
    return [record for record in log if record["record"] == kind]


@forged("nothing for the log's frame at t = 0.0 s: the file ends")
def no_line(lines):
    return []


@forged("regions.jsonl.gz, line 1 (t = 0.0 s, robot 0): what is proved is no closed polygon")
def one_line_of_each_step(lines):
    return [next(line for line in lines if line["t"] == t and "side" not in line) for t in times(lines)]


@forged("what is proved is no closed polygon")
def one_line(lines):
    return [line for line in lines if "side" not in line][:1]


@forged("nothing for the log's frame at t = 0.1 s: the file ends")
def the_first_step(lines):
    return [line for line in lines if line["t"] == lines[0]["t"]]


@forged("the file ends")
def all_but_the_last_step(lines):
    return [line for line in lines if line["t"] != lines[-1]["t"]]


@forged("nothing for the log's frame at t = 0.4")
def a_step_in_between(lines):
    return [line for line in lines if line["t"] != times(lines)[4]]


@forged("nothing for the log's frame at t = 0.1 s")
def two_steps_exchanged(lines):
    order = times(lines)
    order[1], order[2] = order[2], order[1]
    return sorted(lines, key=lambda line: order.index(line["t"]))


@forged("it is of none of the log's frames, or out of order")
def a_line_at_the_end(lines):
    lines.append(lines[0])


@forged("what is proved is no closed polygon")
def a_robot_of_the_last_step(lines):
    return [line for line in lines if not (line["t"] == lines[-1]["t"] and line["robot"] == 1)]


@forged("what is shown is smaller than what is proved")
def an_edge(lines):
    edges = [line for line in of_last(lines) if line["from"] < 0 and line["robot"] == 1 and "side" not in line]
    lines.remove(next(line for line in edges if "0x0.0p+0" not in line["normal"]))


@forged("which is no frame so far")
def a_source_of_the_future(lines):
    source = next(line for line in lines if line["t"] == times(lines)[2] and line["rows"])["sources"][0]
    source.update(t=times(lines)[3], kind="region")


@forged("follows from nothing known")
def a_source_of_another(lines):
    rows = [(row, source) for line in lines for row, source in zip(line["rows"], line["sources"], strict=True)]
    row, source = next((row, source) for row, source in rows if source["kind"] == "range" and row["i"] >= 0)
    source["robot"], source["target"] = 2, 3
    row["offset"] = moved(row["offset"], -1e-9)


@forged("a side that the target may be")
def an_edge_as_a_side(lines):
    """Whatever landmark it is said of, some edge of a region has it on its inner side."""
    for line in lines:
        if line["from"] < 0 and "side" not in line:
            line["side"] = 3


@forged("of which the line does not speak")
def a_side_of_somebody_else(lines):
    next(line for line in lines if line.get("side", -1) >= 0 and line["from"] >= 0)["side"] += 1


@forged("an offset that is greater by")
def a_side_that_is_tilted(lines):
    line = next(line for line in lines if "side" in line and line["from"] >= 0)
    x, y = map(float.fromhex, line["normal"])
    turned = min(((x - k * y, y + k * x) for k in (0.3, -0.3)), key=lambda way: way[0] * x + way[1])
    line["normal"] = [value.hex() for value in turned]


@forged("is not proved", HEADINGS)
def headings_of_a_tenth(lines):
    for line in lines:
        line["bound"] = [(float.fromhex(bound) / 10).hex() for bound in line["bound"]]


@forged("the heading of robot 2 is not proved", HEADINGS)
def a_heading_a_little_narrower(lines):
    lines[5]["bound"][2] = (float.fromhex(lines[5]["bound"][2]) * (1 - 1e-9)).hex()


@forged("the heading of robot 0 is not proved", HEADINGS)
def a_heading_the_other_way(lines):
    lines[0]["centre"][0] = moved(lines[0]["centre"][0], np.pi)


@forged("the heading of robot 1 is not proved", HEADINGS)
def a_heading_of_nothing(lines):
    lines[3]["bound"][1] = (-1.0).hex()


@forged("is not proved", HEADINGS)
def headings_without_sides(lines):
    for line in lines:
        line["lines"] = []


@forged("is not proved", HEADINGS)
def headings_with_one_side_of_two(lines):
    for line in lines:
        line["lines"] = line["lines"][:1]


def case_of(lines):
    """Return the first of what was found case by case."""
    return next(line for record in lines for line in record["lines"] if "pieces" in line)


@forged("can be beyond what is claimed", HEADINGS)
def a_case_of_a_smaller_place(lines):
    claim = case_of(lines)["claims"][2]
    claim["offset"] = moved(claim["offset"], -1e-4)


@forged("can look elsewhere than what is claimed", HEADINGS)
def a_case_of_a_narrower_heading(lines):
    heading = case_of(lines)["heading"]
    heading[1] = (float.fromhex(heading[1]) * 0.9).hex()


@forged("can be beyond what is claimed", HEADINGS)
def a_case_that_nothing_cuts(lines):
    for piece in case_of(lines)["pieces"]:
        piece["rounds"] = 0


@forged("there are pieces that no case is about", HEADINGS)
def a_piece_less(lines):
    case_of(lines)["pieces"].pop()


@forged("IndexError: pop from empty list", HEADINGS)
def a_piece_more(lines):
    pieces = case_of(lines)["pieces"]
    pieces.append(pieces[-1])


@forged("rounds from 0 to 10 were expected", HEADINGS)
def a_piece_that_is_cut_for_ever(lines):
    case_of(lines)["pieces"][0]["rounds"] = 10**9


@forged("rad apart", HEADINGS)
def a_case_of_tangents_without_end(lines):
    case_of(lines)["spacing"] = (1e-9).hex()


@forged("can be beyond what is claimed", HEADINGS)
def a_case_of_readings_that_are_not_said(lines):
    case_of(lines)["said"].clear()


@forged("can be beyond what is claimed", HEADINGS)
def a_case_after_a_heading_of_many_turns(lines):
    """Claimed is the whole circle, so far off that floats see no turn on which it meets what is measured."""
    case = case_of(lines)
    before = next(record for record in lines if case in record["lines"])
    wide = {**before, "lines": [], "centre": [(1e22).hex()] * 3, "bound": [(4.0).hex()] * 3}
    claim = case["claims"][2]
    claim["offset"] = moved(claim["offset"], -0.3)
    return [wide, *lines]


@forged("are too many", HEADINGS)
def a_case_that_takes_for_ever(lines):
    case = case_of(lines)
    case.update(spacing=(0.01).hex(), pieces=[{"rounds": 10}] * 1000)


@forged("version 2, where version 3 is read", HEADINGS)
def a_line_of_another_version(lines):
    case_of(lines)["version"] = 2


@forged(r"a pair '\\x1b[2K\\r9 certificates proved, 0 failed', 0 that is none")
def a_verdict_of_their_own(lines):
    lines[2]["from"] = "\x1b[2K\r9 certificates proved, 0 failed"


@forged("follows from nothing known", HEADINGS)
def a_case_that_begins_too_small(lines):
    row = case_of(lines)["rows"][0]
    row["offset"] = moved(row["offset"], -1e-3)


@forged("box lies", HEADINGS)
def a_case_in_a_smaller_box(lines):
    case = case_of(lines)
    corner = case["upper"][str(case["robot"])]
    corner[0] = moved(corner[0], -1e-3)


@forged("a row on (0, 1) follows from nothing known", HEADINGS)
def a_case_from_a_row_on_a_pair(lines):
    known = next(line for record in lines for line in record["lines"] if "side" in line and line["from"] == 0)
    case = case_of(lines)
    case["rows"].append({"i": known["from"], "j": known["robot"], "normal": known["normal"], "offset": known["offset"]})
    case["sources"].append(case["sources"][0])


@forged("follows from nothing known; it says it is of {'kind': 'cells'", HEADINGS)
def a_case_less(lines):
    for record in lines:
        record["lines"] = [line for line in record["lines"] if "pieces" not in line]


@forged("nothing for the log's frame at t = 0.3", HEADINGS)
def a_step_of_headings(lines):
    return [line for line in lines if line["t"] != times(lines)[3]]


@forged("headings of 2 robots, where there are 3", HEADINGS)
def headings_of_two(lines):
    for name in ("centre", "bound"):
        lines[2][name].pop()


@forged("ValueError: zip() argument", HEADINGS)
def a_heading_without_bound(lines):
    lines[2]["bound"].pop()


@forged("what is shown is smaller than what is proved", REGIONS)
def a_region_a_micrometre_smaller(lines):
    vertices = lines[4]["regions"][1]["vertices"]
    middle = [sum(float.fromhex(vertex[k]) for vertex in vertices) / len(vertices) for k in range(2)]
    size = max(abs(float.fromhex(vertex[k]) - middle[k]) for vertex in vertices for k in range(2))
    for vertex in vertices:
        vertex[:] = [moved(x, (m - float.fromhex(x)) * 1e-6 / size) for x, m in zip(vertex, middle, strict=True)]


@forged("what is shown is larger than what is proved", REGIONS)
def regions_of_two_robots_exchanged(lines):
    lines[-1]["regions"][:2] = lines[-1]["regions"][1::-1]


@forged("what is shown is smaller than what is proved", REGIONS)
def a_corner_cut_off(lines):
    lines[3]["regions"][0]["vertices"].pop()


@forged("what is shown is larger than what is proved", REGIONS)
def a_corner_at_the_end_of_the_world(lines):
    """What is shown is exact to a share of its coordinates: of what is proved, not of what is shown."""
    vertices = lines[4]["regions"][1]["vertices"]
    vertices[1] = [(1e300).hex(), vertices[1][1]]
    del vertices[2:]


@forged("what is shown is larger than what is proved", REGIONS)
def a_region_a_micrometre_larger(lines):
    vertices = lines[4]["regions"][1]["vertices"]
    right = max(vertices, key=lambda vertex: float.fromhex(vertex[0]))
    right[0] = moved(right[0], 1e-6)


@forged("a region without a vertex", REGIONS)
def a_region_without_vertices(lines):
    lines[3]["regions"][0]["vertices"] = []


@forged("m2 is shown of a polygon of", REGIONS)
def an_area(lines):
    lines[3]["regions"][2]["area"] = (float.fromhex(lines[3]["regions"][2]["area"]) * 0.999).hex()


@forged("the estimate is outside the region", REGIONS)
def an_estimate(lines):
    lines[3]["regions"][2]["estimate"][0] = moved(lines[3]["regions"][2]["estimate"][0], 3.0)


@forged("one record of 3 regions was expected", REGIONS)
def a_region(lines):
    lines[3]["regions"].pop()


@forged("one record of 3 regions was expected", REGIONS)
def a_step_shown_twice(lines):
    lines.insert(3, lines[3])


@forged("regions.jsonl.gz: there is nothing for the log's frame at t = 0.7", REGIONS)
def the_last_regions(lines):
    del lines[-1]


@forged("outer_area_mean_m2 is", SUMMARY)
def a_smaller_mean(told):
    told["outer_area_mean_m2"] *= 1 - 1e-4


@forged("outer_area_p95_m2 is", SUMMARY)
def a_smaller_worst(told):
    told["outer_area_p95_m2"] *= 1 - 1e-4


@forged("point_rmse_m is", SUMMARY)
def a_smaller_error(told):
    told["point_rmse_m"] *= 0.9


@forged("checks is 23, where 24 was expected", SUMMARY)
def fewer_checks(told):
    told["checks"] -= 1


@forged("there is no escapes", SUMMARY)
def no_escapes(told):
    del told["escapes"]


@forged("inconsistent is 'robots 0 and 1'", SUMMARY)
def a_run_that_stopped(told):
    told["inconsistent"] = "robots 0 and 1"


@forged("though something was rejected", SUMMARY)
def a_guarantee(told):
    told["rejected"] = 3


@forged("a whole number from 0 to 9007199254740991 was expected, not 1.5", SUMMARY)
def a_part_of_a_rejection(told):
    told.update(guarantee_in_force=False, rejected=1.5)


@forged("escapes_in_force is 1, where 0 were outside", SUMMARY)
def another_number_of_escapes(told):
    told["escapes_in_force"] = 1


@forged("another pose than the region's", FIRST)
def a_pose(lines):
    words = lines[4].split()
    lines[4] = " ".join([words[0], repr(float(words[1]) + 1e-6), *words[2:]])


@forged("another pose than the region's", TUM)
def a_pose_that_looks_elsewhere(lines):
    words = lines[2].split()
    lines[2] = " ".join([*words[:6], *(repr(float(value)) for value in (np.sin(0.3), np.cos(0.3)))])


@forged("another pose than the region's", TUM)
def a_pose_below_the_ground(lines):
    words = lines[3].split()
    lines[3] = " ".join([*words[:3], "-1.0", *words[4:]])


@forged("another pose than the region's", TUM)
def a_pose_that_is_tipped_over(lines):
    words = lines[3].split()
    lines[3] = " ".join([*words[:4], "0.7", *words[5:]])


@forged("7 whole lines, where there are 8 frames with it", TUM)
def a_pose_less(lines):
    lines.pop()


@forged("nothing for the log's frame at t = 0.8", LOG)
def a_frame_more_in_the_log(log):
    log.append({"record": "frame", "time": 0.8})


@forged("it is of none of the log's frames", LOG)
def a_frame_less_in_the_log(log):
    last = log[-1]["time"]
    return [record for record in log if record.get("time") != last]


@forged("the log ends within a frame", LOG)
def a_frame_without_end(log):
    log.pop()


@forged("box lies", LOG)
def wider_odometry(log):
    all_of(log, "odometry")[0]["distance_bound"] = 0.5


@forged("box lies", LOG)
def no_odometry(log):
    log.remove(all_of(log, "odometry")[0])


@forged("box lies", LOG)
def faster_robots(log):
    log[0]["speed_limit"] *= 2


@forged("box lies", LOG)
def robots_that_turn_more(log):
    all_of(log, "odometry")[0]["turn_bound"] = 1.0


@forged("beyond what is claimed", LOG)
def wider_compasses(log):
    for record in all_of(log, "compass"):
        record["bound"] = [2 * bound for bound in record["bound"]]


@forged("beyond what is claimed", LOG)
def wider_bearings(log):
    for record in all_of(log, "bearing"):
        record["bound"] = [1.1 * bound for bound in record["bound"]]


@forged("beyond what is claimed", LOG)
def wider_ranges(log):
    for record in all_of(log, "range"):
        record["bound"] = [bound + 0.01 for bound in record["bound"]]


@forged("box lies", LOG)
def a_larger_start(log):
    log[2]["vertices"].append([x - 0.3 for x in log[2]["vertices"][2]])


@forged("beyond what is claimed", LOG)
def a_landmark_elsewhere(log):
    log[0]["landmarks"][0][0] += 0.1


@forged("escapes is 0, where 1 was expected", LOG)
def a_truth_outside(log):
    all_of(log, "truth")[3]["positions"][1][0] += 2.0


@forged("heading_escapes is 0, where 1 was expected", LOG)
def a_truth_that_looks_elsewhere(log):
    all_of(log, "truth")[3]["headings"][1] += 1.0


@forged("a number from 0 on was expected, not -0.01", LOG)
def a_bound_below_zero(log):
    all_of(log, "bearing")[0]["bound"] = -0.01


@forged("t = 0.3 s does not come after 0.7", LOG)
def a_frame_that_comes_late(log):
    log.append({"record": "frame", "time": 0.3})


@forged("nothing for the log's frame at t = 0.7", LOG)
def a_log_out_of_order(log):
    log[4:] = [record for time in (0.7, 0.0) for record in log[4:] if abs(record["time"] - time) < 0.01]


@forged("a log of version 1 or 2 was expected, not 'corral-log', version 3", LOG)
def a_log_of_another_version(log):
    log[0]["version"] = 3


@forged("at least one frame was expected", LOG)
def a_log_without_frames(log):
    del log[4:]


@forged("a second initial set of robot 0", LOG)
def a_robot_that_begins_twice(log):
    log[2]["robot"] = 0


@forged("an initial set without a point", LOG)
def a_start_that_is_empty(log):
    log[1]["vertices"] = []


@forged("a relative bound of 1 or more", LOG)
def a_range_that_says_nothing(log):
    all_of(log, "range")[0]["relative_bound"] = 1.0


@forged("in a frame of t = 0.0 s", LOG)
def a_record_of_another_time(log):
    all_of(log, "bearing")[0]["time"] = 0.1


@forged("one truth of 3 robots was expected", LOG)
def a_truth_of_two(log):
    for column in ("positions", "headings"):
        all_of(log, "truth")[0][column].pop()


@forged("a record 'sonar' that there is not", LOG)
def a_record_of_another_kind(log):
    all_of(log, "range")[0]["record"] = "sonar"


@forged("odometry from 0.0 s on, where other odometry ends at 0.1 s", LOG)
def odometry_said_twice(log):
    log.insert(log.index(all_of(log, "odometry")[0]), all_of(log, "odometry")[0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("forged"))


@pytest.fixture
def copy(folder, tmp_path):
    return Path(shutil.copytree(folder, tmp_path / "copy"))


def test_the_folder_is_proved_as_it_is(copy):
    for name in (LINES, HEADINGS, REGIONS, LOG):
        rewritten(copy, lines_of(copy, name), name)
    assert prove.main([str(copy)]) == 0


def changed(path, change):
    """Change what is in a file of any kind."""
    if path.suffix == ".json":
        told = json.loads(path.read_text())
        change(told)
        path.write_text(json.dumps(told) + "\n")
    elif path.suffix == ".tum":
        lines = path.read_text().splitlines()
        change(lines)
        path.write_text("".join(f"{line}\n" for line in lines))
    else:
        lines = lines_of(path.parent, path.name)
        other = change(lines)
        rewritten(path.parent, lines if other is None else other, path.name)


@pytest.mark.parametrize("name", FORGED)
def test_what_is_forged_or_cut_is_refused(copy, name, capsys):
    file, change, why = FORGED[name]
    before = (copy / file).read_bytes()
    changed(copy / file, change)
    assert (copy / file).read_bytes() != before
    assert prove.main([str(copy)]) == 1
    told = capsys.readouterr().out
    assert told.startswith("not proved: ")
    assert why in told


def test_the_lines_of_another_run_prove_nothing_here(copy, tmp_path, capsys):
    other = run_of(tmp_path, size=5.0)
    assert prove.main([str(other)]) == 0
    capsys.readouterr()
    for names in ((LINES,), (LINES, HEADINGS), (LINES, HEADINGS, REGIONS, SUMMARY)):
        for name in names:
            (copy / name).write_bytes((other / name).read_bytes())
        assert prove.main([str(copy)]) == 1


def test_the_recording_of_another_run_is_refused(copy, tmp_path, capsys):
    other = run_of(tmp_path, size=5.0)
    (other / "moving_team.rrd").write_bytes((copy / "moving_team.rrd").read_bytes())
    assert prove.main([str(other)]) == 1
    assert "not proved: moving_team.rrd: /world/outer/ shows another polygon" in capsys.readouterr().out


def test_there_are_many():
    assert len(FORGED) > 60
