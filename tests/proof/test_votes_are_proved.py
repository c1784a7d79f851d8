"""Runs in which one vote on each robot may be wrong are proved from slices without each of them; what is forged is refused."""

import json
import shutil

import numpy as np
import pytest
from helpers.drawn.broken import going_on
from helpers.drawn.lies import lied
from helpers.proved.forgeries import LOG, Forgeries, check_refused
from helpers.proved.runs import HEADINGS, lines_of, moved, rewritten, run_of
from helpers.worlds import World

from experiments import prove
from experiments.follow import main as followed
from experiments.logs import Certificates, Header, InitialSet, LogWriter
from experiments.prove import SUMMARY
from filter import Frame, InvalidInput, Suspect, Tolerance, Truth, follow

LIAR, AT = Suspect("sighting", 0, 3), 3


def voted(path, seed, window, *, robots=2, landmarks=3, compasses=False, steps=6):
    """Return the folder of a run in which once a robot takes a landmark for another one."""
    world = World(np.random.default_rng(seed), robots=robots, landmarks=landmarks, errors="extreme", sight=9.0)
    arcs = world.initial_headings(0.4)
    heads = zip(arcs.centre.tolist(), arcs.bound.tolist(), strict=True)
    initial = [InitialSet(one.vertices, head) for one, head in zip(world.initial_sets(), heads, strict=True)]
    with LogWriter(path / "given.jsonl", Header(world.team, 0.0, 2.5), initial) as log:
        for k in range(steps):
            motion, told = world.tour() if k else None, tuple(world.measure(compasses=compasses))
            frame = Frame(world.time, motion, told, Truth(world.positions, world.headings))
            log.write(lied(frame, LIAR, np.random.default_rng(1), size=2.0) if k == AT else frame)
    folder, votes = path / "run", ["--tolerate", "1", "--suspects", "identities", "--window", str(window)]
    how = ["--every", "0", "--certificates", "--light", *votes, "--out", str(folder)]
    assert followed([str(path / "given.jsonl"), *how]) == 0
    return folder


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return voted(tmp_path_factory.mktemp("votes"), 0, 10.0)


def test_a_run_with_votes_is_proved_and_says_under_which_condition(run, capsys):
    assert prove.main([str(run)]) == 0
    told = capsys.readouterr().out
    assert (
        "3 on trust: that in a window, of 2 s at most, no more than one vote on its robot is wrong, each of 0.8 s at most"
        in told
    )
    assert "robots, by votes" in told


@pytest.mark.parametrize(("seed", "window", "compasses"), [(1, 1.5, False), (2, 4.0, True), (3, 10.0, False)])
def test_others_are_too(tmp_path, seed, window, compasses):
    assert prove.main([str(voted(tmp_path, seed, window, robots=1 + seed % 2, compasses=compasses))]) == 0


def polls(lines):
    """Return the records of votes, of all steps."""
    return [line for record in lines for line in record["lines"] if "cases" in line]


forged = Forgeries()


@forged("a first window that begins with less", HEADINGS)
def a_first_window_that_begins_with_less(lines):
    for each in polls(lines)[0]["begun"]:
        each["reach"] = [moved(far, -0.01) for far in each["reach"]]


@forged("no first window begins", HEADINGS)
def no_window(lines):
    polls(lines)[0]["begun"] = None


@forged("slices that are less than those", HEADINGS)
def a_window_that_begins_anew_with_less(lines):
    polls(lines)[-1]["begun"] = polls(lines)[-1]["begun"] or []


@forged("slices that are less than those", HEADINGS)
def earlier_slices_that_are_left_out(lines):
    del next(line for line in polls(lines) if line["earlier"])["earlier"][1:]  # one of them may be in others


@forged("a vote that is over, and no earlier slices", HEADINGS)
def no_earlier_slices(lines):
    next(line for line in polls(lines) if line["earlier"])["earlier"] = None


@forged("slices that are less than those", HEADINGS)
def a_window_that_ends_with_less(lines):
    next(line for line in polls(lines) if line["ended"])["ended"].pop()


@forged("slices that are less than those", HEADINGS)
def roots_that_reach_less_far(lines):
    case = next(case for line in polls(lines) for case in line["cases"] if case["vote"] == "earlier")
    for root in case["roots"]:  # one of them may be in others
        root["reach"] = [moved(far, -1e-6) for far in root["reach"]]


@forged("slices that are less than those", HEADINGS)
def a_root_that_is_left_out(lines):
    polls(lines)[-1]["cases"][-1]["roots"] = []


@forged("uses what is left out in it", HEADINGS)
def a_case_that_hears_what_it_does_without(lines):
    line = polls(lines)[0]
    case = next(case for case in line["cases"] if isinstance(case["vote"], list))
    case["said"] = next(case for case in line["cases"] if case["vote"] == "agreed")["said"]


@forged("said in no vote", HEADINGS)
def a_vote_that_is_none(lines):
    line = polls(lines)[0]
    left_out = line["new"].pop()
    line["cases"] = [case for case in line["cases"] if case["vote"] != left_out]


@forged("a case without a vote that there is not", HEADINGS)
def a_case_without_a_vote_that_there_is_not(lines):
    line = polls(lines)[0]
    line["cases"] = [{**line["cases"][0], "vote": line["new"].pop()}]


@forged("votes on robot", HEADINGS)
def a_vote_on_somebody_else(lines):
    line = next(line for line in polls(lines) if line["robot"] == 0)
    line["new"].append([1, 4])


@forged("no slices, where", HEADINGS)
def a_case_that_is_said_to_be_empty(lines):
    case = next(case for line in polls(lines) for case in line["cases"] if case.get("slices"))
    case["slices"] = []


@forged("no slices, where", HEADINGS)
def a_new_vote_without_which_nothing_is_said_to_be_left(lines):
    case = next(case for case in polls(lines)[0]["cases"] if isinstance(case["vote"], list))
    case["slices"] = []


@forged("can be beyond its slices", HEADINGS)
def slices_that_reach_less_far(lines):
    case = next(case for line in polls(lines) for case in line["cases"] if case.get("slices"))
    for each in case["slices"]:
        each["reach"] = [moved(far, -0.05) for far in each["reach"]]


@forged("can be elsewhere than what is claimed", HEADINGS)
def a_heading_that_is_narrower(lines):
    line = polls(lines)[-1]
    line["heading"][1] = (float.fromhex(line["heading"][1]) * 0.9).hex()


@forged("can be elsewhere than what is claimed", HEADINGS)
def places_that_reach_less_far(lines):
    polls(lines)[-1]["reach"][7] = moved(polls(lines)[-1]["reach"][7], -1e-3)


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(run, tmp_path, capsys, name):
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    check_refused(copy, forged[name], capsys)


def test_nothing_follows_where_nothing_is_left(run, tmp_path, capsys):
    """All ranges of robot 0 are too long in the end: each case is empty, and it may not be said to be anywhere."""
    copy = shutil.copytree(run, tmp_path / "copy")
    records, lines = lines_of(copy, LOG), lines_of(copy, HEADINGS)
    ranges = [record for record in records if record["record"] == "range"][-1]
    ranges["range"] = [50.0 if robot == 0 else far for robot, far in zip(ranges["robot"], ranges["range"], strict=True)]
    for case in [line for line in polls(lines) if line["robot"] == 0][-1]["cases"]:
        case["slices"] = []
    rewritten(copy, records, LOG)
    rewritten(copy, lines, HEADINGS)
    assert prove.main([str(copy)]) == 1
    assert "nothing is left of the poses of robot 0" in capsys.readouterr().out


def test_there_are_no_certificates_where_more_is_wrong_than_is_tolerated(tmp_path):
    world = World(np.random.default_rng(4), 1, 6, 5.0, sight=9.0)
    filter_ = going_on(world.team, tolerance=Tolerance(1, 99.0, "identities"))
    before = filter_.start(0.0, world.initial_sets(), world.initial_headings(0.3))
    with Certificates(tmp_path, world.team) as file, pytest.raises(InvalidInput, match="where lies are tolerated"):
        for k in range(4):
            motion = world.tour() if k else None
            frame = Frame(world.time, motion, tuple(world.measure()))
            for target in (2, 5) if k == AT else ():
                frame = lied(frame, Suspect("sighting", 0, target), np.random.default_rng(0), size=target)
            (step,) = follow(filter_, before, [frame])
            file.write(step)
            before = step.belief


def summary_with(folder, **more):
    told = json.loads((folder / SUMMARY).read_text())
    (folder / SUMMARY).write_text(json.dumps(told | more) + "\n")


def test_votes_are_none_where_nothing_is_said_to_be_tolerated(run, tmp_path, capsys):
    copy = shutil.copytree(run, tmp_path / "copy")
    summary_with(copy, tolerated="")
    assert prove.main([str(copy)]) == 1
    assert "votes, where the summary says that nothing is tolerated" in capsys.readouterr().out


def test_what_is_believed_is_no_proof_where_some_of_it_is_said_to_be_tolerated(tmp_path, capsys):
    """A run that believes every sighting would prove smaller regions than votes allow."""
    folder = run_of(tmp_path, steps=1)
    summary_with(folder, tolerated=str(Tolerance(1, 5.0, "identities")))
    assert prove.main([str(folder)]) == 1
    assert "not proved" in capsys.readouterr().out


@pytest.mark.parametrize("told", [str(Tolerance(1, 5.0, "pairs")), str(Tolerance(1, 5.0, "identities")) + ", or more", 1])
def test_votes_prove_nothing_of_another_tolerance(run, tmp_path, capsys, told):
    """What is proved holds if of each robot one vote is wrong; a summary may not say that it holds if something else is."""
    copy = shutil.copytree(run, tmp_path / "copy")
    summary_with(copy, tolerated=told)
    assert prove.main([str(copy)]) == 1
    assert "not proved: " in capsys.readouterr().out
