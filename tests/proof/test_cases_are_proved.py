"""Runs that tolerate lies by a belief for each case of who lies are proved, case by case; what is forged is refused."""

import json
import shutil

import numpy as np
import pytest
from helpers.drawn.lies import lied
from helpers.proved.forgeries import Forgeries, Forgery, check_refused
from helpers.proved.runs import HEADINGS, LINES, lines_of, moved
from helpers.worlds import World

from experiments import prove
from experiments.follow import main as followed
from experiments.logs import Certificates, Header, InitialSet, LogWriter
from experiments.prove import ALTERNATIVES, SUMMARY
from filter import Frame, InvalidInput, SetMembershipFilter, Suspect, Tolerance, Truth, follow

LIAR, AT = Suspect("sighting", 0, 3), 3
WINDOW = 1.0  # [s]: three frames, 0.4 s each


def tolerated(path, seed, *options, window=WINDOW, robots=2, landmarks=2, compasses=True, steps=5, wide=0.1, lies=True):
    """Return the folder of a run in which once a robot takes a landmark for another one."""
    world = World(np.random.default_rng(seed), robots=robots, landmarks=landmarks, errors="extreme", sight=9.0)
    arcs = world.initial_headings(wide)
    heads = zip(arcs.centre.tolist(), arcs.bound.tolist(), strict=True)
    initial = [InitialSet(one.vertices, head) for one, head in zip(world.initial_sets(), heads, strict=True)]
    with LogWriter(path / "given.jsonl", Header(world.team, 0.0, 2.5), initial) as log:
        for k in range(steps):
            motion, told = world.tour() if k else None, tuple(world.measure(compasses=compasses))
            frame = Frame(world.time, motion, told, Truth(world.positions, world.headings))
            log.write(lied(frame, LIAR, np.random.default_rng(1), size=2.0) if lies and k == AT else frame)
    folder, how = path / "run", ["--tolerate", "1", "--window", str(window), *options]
    assert followed([str(path / "given.jsonl"), "--every", "0", "--certificates", "--light", *how, "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return tolerated(tmp_path_factory.mktemp("cases"), 0)


def test_a_run_is_proved_in_each_case_and_says_under_which_condition(run, capsys):
    assert prove.main([str(run)]) == 0
    told = capsys.readouterr().out
    assert "if at most 1 of these is wrong within any 1 s: what a robot takes for a target" in told


@pytest.mark.parametrize(
    ("seed", "options", "how"),
    [
        (2, ["--suspects", "cameras"], {"robots": 3, "landmarks": 1}),
        (3, ["--suspects", "compasses", "pairs"], {"robots": 1}),
        (4, ["--lies", "long"], {"lies": False, "robots": 1}),
        (5, ["--lies", "long", "--suspects", "bodies"], {"lies": False, "compasses": False, "wide": 0.4}),
        (6, ["--tolerate", "2", "--suspects", "bodies"], {"robots": 1, "compasses": False, "wide": 0.4}),
        (9, [], {"robots": 1, "compasses": False, "wide": 0.4, "window": 0.7}),
    ],
)
def test_others_are_too(tmp_path, seed, options, how):
    assert prove.main([str(tolerated(tmp_path, seed, *options, **how))]) == 0


def test_cases_end_and_become_one_with_pairs_and_slices(run, sliced):
    records = lines_of(run, ALTERNATIVES)
    (united,) = (record for record in records if "united" in record)
    assert len(united["united"]) > 1
    assert all(each["lines"] for each in united["united"])
    assert any("empty" in line for record in records for line in [*record["headings"], *record["lines"]])
    assert any(record["slices"] for record in lines_of(sliced, ALTERNATIVES) if "united" in record)


@pytest.fixture(scope="module")
def sliced(tmp_path_factory):
    return tolerated(tmp_path_factory.mktemp("sliced"), 9, compasses=False, wide=0.4, robots=1, window=0.7, steps=4)


forged = Forgeries()


@forged("cases, where there are", ALTERNATIVES)
def a_case_that_is_left_out(lines):
    del lines[1]


@forged("cases, where there are", ALTERNATIVES)
def a_case_that_ends_without_a_proof(lines):
    lines.remove(next(line for line in lines if line["t"] == lines[-1]["t"]))


@forged("a case that there is not, or is there already", ALTERNATIVES)
def a_case_twice(lines):
    lines[2]["lying"] = lines[1]["lying"]


@forged("a case that there is not, or is there already", ALTERNATIVES)
def more_lie_than_are_tolerated(lines):
    lines[1]["lying"] = lines[1]["lying"] + lines[2]["lying"]


@forged("a case that there is not, or is there already", ALTERNATIVES)
def another_thing_lies(lines):
    lines[1]["lying"] = [["body", -1, 2]]


@forged("the heading of robot 0 is not proved", ALTERNATIVES)
def a_case_that_hears_who_lies_in_it(lines):
    nobody, *others = (line for line in lines if line["t"] == lines[0]["t"])
    for other in others:
        other["headings"], other["lines"] = nobody["headings"], nobody["lines"]


@forged("", ALTERNATIVES)
def a_case_that_is_said_to_be_empty(lines):
    line = lines[1]["lines"][-1]
    line |= {"empty": True, "from": -1, "normal": ["0x0p+0", "0x0p+0"], "offset": "-0x1p-20"}


@forged("an edge of the cover", LINES)
def an_edge_of_the_cover_that_is_too_near(lines):
    lines[0]["offset"] = moved(lines[0]["offset"], -1e-3)


@forged("a heading of the cover", HEADINGS)
def an_arc_of_the_cover_that_is_too_narrow(lines):
    lines[0]["bound"] = [moved(bound, -1e-3) for bound in lines[0]["bound"]]


def union(lines):
    return next(line for line in lines if "united" in line)


@forged("other cases become one", ALTERNATIVES)
def a_case_that_does_not_become_one_with_the_others(lines):
    union(lines)["united"].pop()


@forged("an edge of the cover", ALTERNATIVES)
def a_union_that_says_too_much_of_a_robot(lines):
    line = next(line for line in union(lines)["lines"] if line["from"] == -1)
    line["offset"] = moved(line["offset"], -1e-3)


@forged("an edge of the cover", ALTERNATIVES)
def a_union_that_says_too_much_of_a_pair(lines):
    line = next(line for line in union(lines)["lines"] if line["from"] == 0)
    line["offset"] = moved(line["offset"], -1e-3)


@forged("its rows prove an offset that is greater", ALTERNATIVES)
def a_case_that_says_too_much_of_a_pair(lines):
    line = union(lines)["united"][0]["lines"][0]
    line["offset"] = moved(line["offset"], -1e-3)


@forged("an edge of the cover", ALTERNATIVES)
def a_case_of_which_nothing_is_said_of_pairs(lines):
    union(lines)["united"][0]["lines"] = []


@forged("a window that began", ALTERNATIVES)
def a_window_that_does_not_end(lines):
    lines.remove(union(lines))


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(run, tmp_path, capsys, name):
    check_refused(shutil.copytree(run, tmp_path / "copy"), forged[name], capsys)


def test_slices_that_are_less_are_refused(sliced, tmp_path, capsys):
    def narrowed(lines):
        for each in union(lines)["slices"][0]["slices"]:
            each["reach"] = [moved(far, -1e-4) for far in each["reach"]]

    check_refused(
        shutil.copytree(sliced, tmp_path / "copy"), Forgery(narrowed, "slices of robot 0", ALTERNATIVES, None), capsys
    )


def test_that_a_range_is_too_long_is_no_reason_to_use_its_near_side(tmp_path, capsys):
    copy = tolerated(tmp_path, 4, "--lies", "long", lies=False, robots=1, steps=2)
    capsys.readouterr()
    check_refused(copy, Forgery(a_case_that_hears_who_lies_in_it, "not proved", ALTERNATIVES, None), capsys)


@pytest.mark.parametrize(
    ("told", "why"),
    [
        (Tolerance(1, 0.5, "pairs"), "a window that began"),
        (Tolerance(2, WINDOW, "pairs"), "cases, where there are"),
        (Tolerance(1, WINDOW, "bodies"), "a case that there is not"),
        (Tolerance(1, WINDOW, ("pairs", "compasses")), "cases, where there are"),
        (Tolerance(1, WINDOW, "identities"), "a doubt"),
        ("", "not as it should be"),
        (f"{Tolerance(1, WINDOW, 'pairs')} or anything", "what can be tolerated"),
    ],
)
def test_what_is_proved_holds_under_the_condition_that_is_said_alone(run, tmp_path, capsys, told, why):
    copy = shutil.copytree(run, tmp_path / "copy")
    summary = json.loads((copy / SUMMARY).read_text())
    (copy / SUMMARY).write_text(json.dumps(summary | {"tolerated": str(told)}) + "\n")
    assert prove.main([str(copy)]) == 1
    said = capsys.readouterr().out
    assert said.startswith("not proved: ")
    assert why in said, said


def test_where_less_can_be_wrong_the_same_holds(run, tmp_path):
    copy = shutil.copytree(run, tmp_path / "copy")
    summary = json.loads((copy / SUMMARY).read_text())
    (copy / SUMMARY).write_text(json.dumps(summary | {"tolerated": str(Tolerance(1, WINDOW, "pairs", "long"))}) + "\n")
    assert prove.main([str(copy)]) == 0


def test_of_a_doubt_beside_cases_there_are_no_certificates(tmp_path):
    world = World(np.random.default_rng(0), robots=1, landmarks=3, errors="extreme", sight=9.0)
    filter_ = SetMembershipFilter.light(world.team, tolerance=Tolerance(1, 9.0, "pairs"), policy="reject", each_alone=True)
    before = filter_.start(0.0, world.initial_sets(), world.initial_headings(0.1))
    frame = Frame(0.0, None, tuple(world.measure()))
    for target in (1, 2):
        frame = lied(frame, Suspect("sighting", 0, target), np.random.default_rng(target), size=2.0)
    with Certificates(tmp_path, world.team) as file, pytest.raises(InvalidInput, match="a doubt"):
        file.write(*follow(filter_, before, [frame]))
