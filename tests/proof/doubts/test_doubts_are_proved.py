"""Where something is in doubt: what is said holds in each case; nobody who can be wrong is missing, or gone without proof."""

import shutil
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from helpers.drawn.broken import drawn, outside
from helpers.proved.doubts import FIRST, FRAMES, followed, lied, proved, read_back, refusal, said
from helpers.proved.runs import forge, lines_of, moved

from experiments.follow import main as follow_command
from experiments.logs import Header, InitialSet, LogWriter
from experiments.logs.alternatives import Alternatives
from experiments.proof.alternatives.doubts import Doubts
from experiments.proof.alternatives.wrong import everybody, without, without_both
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken
from experiments.prove import ALTERNATIVES, HEADINGS, LINES
from experiments.prove import main as prove_command
from filter import Bearing, Compass, Doubted, Frame, InvalidInput, Position, Step, Suspect, Team
from filter.diagnosis.replays import _without_them
from filter.diagnosis.suspects import everybody as suspected
from filter.diagnosis.told import without as left_by

FORGED = {}


@pytest.fixture(scope="module")
def settled(tmp_path_factory):
    """Return the folder of a run in which a compass is found to be wrong, and is put aside."""
    path = tmp_path_factory.mktemp("settled")
    assert [suspect.who for suspect in lied(path, Compass)[-1].aside] == [("compass", 0, -1)]
    return path


def test_a_doubt_is_proved_and_says_on_what_it_rests(doubtful):
    assumed, links = proved(doubtful)
    assert list(assumed) == ["on trust: one thing alone was wrong from t = 0.0 s to 0.30000000000000004 s, one of:"]
    assert links["certificates"] > 500


def test_the_end_of_a_doubt_is_proved_and_who_is_put_aside_is_said(settled):
    assumed, _ = proved(settled)
    assert assumed["on trust: from t = 0.30000000000000004 s on nothing is wrong but: compass r0"] == 1


EPISODES = [("swap", 4, 16, 0), ("moved", 2, 18, 0)]


@pytest.mark.parametrize(("kind", "landmarks", "count", "cells"), EPISODES)
def test_an_episode_is_proved_and_the_truth_is_inside(kind, landmarks, count, cells, tmp_path):
    episode, beliefs = followed(tmp_path, kind, landmarks, count, cells)
    assert any(isinstance(event, Doubted) for belief in beliefs for event in belief.events)
    for belief, frame in zip(beliefs[episode.fault.when + 2 :], episode.frames[episode.fault.when + 2 :], strict=False):
        assert not outside(belief, frame.truth).any()
    assumed, _ = proved(tmp_path)
    assert any("one thing alone was wrong" in words for words in assumed)


def forged(why, name=ALTERNATIVES, run="doubtful"):
    """Enter a function that changes the records of a file in place, with the reason of the refusal."""

    def entered(change):
        FORGED[change.__name__] = (name, change, why, run)
        return change

    return entered


def of(records, *wrong):
    """Return the first record of an alternative in which one thing may be wrong."""
    return next(record for record in records if list(wrong) in record.get("wrong", ()))


def dead(records):
    """Return the records of alternatives that are proved to be empty by rows."""
    return [record for record in records if any("empty" in line for line in last(record)["lines"])]


def last(record):
    return record["instants"][-1]


@forged("nobody has looked whether this is wrong: past r1")
def a_suspect_is_missing(records):
    records.remove(of(records, "past", 1, -1))


@forged("nobody has looked whether this is wrong: sensor r0")
def a_suspect_whose_case_is_left_is_missing(records):
    records[:] = [record for record in records if ["sensor", 0, -1] not in record["wrong"]]


@forged("ends without a proof; in it may be wrong: body l0")
def an_alternative_is_dropped(records):
    records.remove([record for record in records if ["body", -1, 2] in record["wrong"]][1])


@forged("a heading of the cover is narrower")
def an_end_without_its_contradiction(records):
    (record, *_) = dead(records)
    last(record)["lines"] = [line for line in last(record)["lines"] if "empty" not in line]


@forged("its rows do not exclude one another")
def a_contradiction_without_a_row(records):
    line = next(line for record in dead(records) for line in last(record)["lines"] if "empty" in line)
    del line["rows"][0], line["sources"][0]


@forged("an empty line that is about something")
def a_claim_as_a_contradiction(records):
    """That a robot is to the left of something is no contradiction, though it is proved to be less than nothing."""
    record = of(records, "sensor", 0, -1)
    some = [line for line in last(record)["lines"] if line["from"] < 0 and float.fromhex(line["offset"]) < 0]
    some[0]["empty"] = True


@forged("there are pieces that no case is about")
def a_contradiction_by_cases_of_which_there_are_none(records):
    """With `pieces` a line is not proved by its rows."""
    line = next(line for record in dead(records) for line in last(record)["lines"] if "empty" in line)
    line.update(rows=[], sources=[], pieces=[], said=[], claims=[], heading=["0x0p+0", "0x1p+2"], spacing="0x1p-1")


@forged("an alternative that ends before it is proved to be empty")
def an_end_before_its_time(records):
    del of(records, "sensor", 0, -1)["instants"][-1]


@forged("headings that agree, where none is said to be left")
def headings_that_agree_are_torn(records):
    heading = last(of(records, "sensor", 0, -1))["headings"][-1]
    del heading["centre"], heading["bound"]
    heading["empty"] = True


@forged("follows from nothing known; it says it is of {'kind': 'bearing'")
def who_is_wrong_is_exchanged(records):
    """What one of them said is left out, and is said to be wrong by the other."""
    one, other = of(records, "sensor", 0, -1), of(records, "sensor", 1, -1)
    one["wrong"], other["wrong"] = other["wrong"], one["wrong"]


@forged("leaves out different readings")
def suspects_that_leave_out_others_are_one(records):
    of(records, "sensor", 0, -1)["wrong"].append(["compass", 1, -1])


@forged("something else is wrong than in the one before")
def another_is_wrong_later(records):
    records[-1]["wrong"] = [["past", 0, -1]]


@forged("a second alternative")
def a_name_twice(records):
    records[1]["name"] = records[0]["name"]


@forged("alternatives from one frame on were expected")
def alternatives_from_another_frame_on(records):
    del of(records, "sensor", 0, -1)["instants"][0]


@forged("one thing that can be wrong was expected")
def something_that_there_is_not(records):
    records[0]["wrong"] = [["weather", 0, -1]]


@forged("where several alternatives are left")
def an_end_of_a_doubt_too_early(records):
    records.append({key: records[-1][key] for key in ("t", "version")} | {"aside": []})


@forged("somebody is put aside who was not found to be wrong", run="settled")
def markers_are_exchanged_instead(records):
    records[-1]["aside"] = [["exchange", 0, 1]]


@forged("somebody is put aside who was not found to be wrong", run="settled")
def another_is_put_aside(records):
    records[-1]["aside"] = [["compass", 1, -1]]


@forged("who was found to be wrong is not put aside", run="settled")
def nobody_is_put_aside(records):
    records[-1]["aside"] = []


@forged("there is nothing for the log's frame", LINES)
def no_cover(lines):
    lines[:] = [line for line in lines if line["t"] != lines[-1]["t"]]


@forged("where an alternative has edges 0.001 m farther out", LINES)
def an_edge_of_the_cover_a_little_farther_in(lines):
    lines[-1]["offset"] = moved(lines[-1]["offset"], -0.001)


@forged("a heading of the cover is narrower than that of an alternative", HEADINGS)
def an_arc_a_little_narrower(lines):
    lines[-1]["bound"][0] = (float.fromhex(lines[-1]["bound"][0]) * (1 - 1e-6)).hex()


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_doubt_is_refused(name, request, tmp_path):
    file, change, why, run = FORGED[name]
    copy = Path(shutil.copytree(request.getfixturevalue(run), tmp_path / "copy"))
    forge(copy, file, change)
    assert why in refusal(copy)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_is_in_a_doubt_there_is_a_verdict_in_words(doubtful, seed, tmp_path):
    rng, copy = np.random.default_rng(seed), Path(shutil.copytree(doubtful, tmp_path / "copy"))

    def change(records):
        inner, keys = records[int(rng.integers(4))], ["x"]
        while isinstance(inner, dict | list) and inner and keys:
            outer, keys = inner, sorted(inner) if isinstance(inner, dict) else range(len(inner))
            key = keys[int(rng.integers(len(keys)))]
            inner = outer[key]
            if rng.random() < 0.3:
                break
        outer[key] = [None, -1, "x", [], {}, [[]], "nan", True][int(rng.integers(8))]

    forge(copy, ALTERNATIVES, change)
    assert isinstance(refusal(copy), str)


def test_a_run_is_proved_from_the_command_line(tmp_path, capsys):
    lied(tmp_path, Compass)
    out = tmp_path / "run"
    assert (
        follow_command([str(tmp_path / "log.jsonl"), "--policy", "reject", "--light", "--certificates", "--out", str(out)]) == 0
    )
    assert prove_command([str(out)]) == 0
    told = capsys.readouterr().out
    assert "on trust: one thing alone was wrong from t = 0.0 s to 0.30000000000000004 s, one of:" in told
    assert "nothing is wrong but: compass r0" in told


def test_nobody_knows_since_when_markers_are_exchanged_nor_where_a_robot_is_whose_past_is_wrong(doubtful):
    doubts, instant = Doubts(Log(doubtful)), {"anew": []}
    doubts._heard = doubts._log.frames[:3]
    seen = [
        {whom for _, _, whom in doubts._left(number, ("exchange", 0, 1), instant, True, False).readings} for number in range(3)
    ]
    assert not {0, 1} & (seen[0] | seen[1])
    assert doubts._left(2, ("exchange", 0, 1), instant, False, False) == without(doubts._heard[2], ("exchange", 0, 1))
    for number in range(3):
        lost = doubts._left(number, ("past", 1, -1), instant, True, False)
        assert set(lost.placed) == {1}
        assert lost.placed[1].place.most((Fraction(1), Fraction(0))) == 10
        assert doubts._left(number, ("past", 1, -1), instant, False, False) == doubts._heard[number]


def test_of_what_was_united_nothing_from_before_counts(doubtful):
    """Else a union would know what only one of its cases does."""
    log, chain, times = Log(doubtful), Doubts(Log(doubtful)).main, list(dict.fromkeys(one["t"] for one in lines_of(doubtful)))
    for time in times[:2]:
        headings, lines = ([("", one) for one in lines_of(doubtful, name) if one["t"] == time] for name in (HEADINGS, LINES))
        chain.check(headings, lines)
    begun, normal = chain.begun(chain.headings, {}), next(iter(chain._proved[0][-1, 0]))
    for each, is_known in ((chain, True), (begun, False)):
        each._begin(log.frames[2])
        for taken in range(2):
            assert bool(each._of_edges((-1, 0), normal, Fraction(10**6), taken)) == is_known
        assert (each._growth((-1, 0, normal, 0)) is not None) == is_known


def contradiction(robot, rows):
    """Return an empty line of rows (normal, offset, kind), each of weight 1, in a box of a hundred metres."""
    zero, far = ["0x0p+0"] * 2, [(100.0).hex()] * 2
    columns = [
        {"i": -1, "j": robot, "normal": [x.hex(), (0.0).hex()], "offset": b.hex(), "multiplier": "0x1p+0"} for x, b, _ in rows
    ]
    sources = [{"kind": kind, "t": (0.0).hex(), "robot": robot, "target": None} for _, _, kind in rows]
    line = {"t": (0.0).hex(), "version": 3, "robot": robot, "from": -1, "normal": zero, "offset": zero[0], "empty": True}
    box = {"lower": {str(robot): [(-100.0).hex()] * 2}, "upper": {str(robot): far}}
    return {**line, **box, "rows": columns, "sources": sources}


def test_where_nothing_is_said_to_be_in_doubt_a_contradiction_proves_nothing(tmp_path):
    initial = [InitialSet(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), (0.0, 0.1))]
    with LogWriter(tmp_path / "log.jsonl", Header(Team(1), 0.0, version=2), initial) as log:
        log.write(Frame(0.0, None, (Position.fix(0.0, 0, [9.0, 0.0], 1.0),)))
    doubts = Doubts(Log(tmp_path))
    heading = {"t": (0.0).hex(), "centre": [(0.0).hex()], "bound": [(0.1).hex()], "lines": []}
    apart = contradiction(0, [(1.0, 1.0, "initial set"), (-1.0, -7.9, "position")])
    with pytest.raises(Broken, match=r"a contradiction at t = 0\.0 s, where nothing is said to be in doubt"):
        doubts.check([("", heading)], [("", apart)], [])
    doubts = Doubts(Log(tmp_path))
    with pytest.raises(Broken, match="do not exclude one another"):
        doubts.check([("", heading)], [("", contradiction(0, [(-1.0, -7.9, "position")]))], [])


def test_without_an_arena_there_are_no_certificates_of_robots_that_are_anywhere(tmp_path):
    with pytest.raises(InvalidInput, match="in a closed arena"):
        lied(tmp_path, Bearing, arena=(-np.inf, np.inf))


def test_of_doubts_that_begin_with_a_motion_there_are_no_certificates(tmp_path):
    belief = lied(tmp_path, Bearing)[FIRST]
    (begun, *_) = belief.diagnosis.tried
    step = Step(Frame(belief.time), replace(belief, diagnosis=replace(belief.diagnosis, tried=(begun,))), belief, 0.0)
    with pytest.raises(InvalidInput, match="begin with what is measured"):
        Alternatives(Team(2, np.zeros((3, 2)))).of(step)


def test_of_suspects_that_are_tried_together_there_are_no_certificates(tmp_path):
    with pytest.raises(InvalidInput, match="in which each suspect was tried alone"):
        followed(tmp_path, "start", 4, 1, 0, each_alone=False)


@pytest.mark.parametrize("landmarks", [1, 4])
def test_who_can_be_wrong_and_what_that_leaves_is_as_in_the_filter(landmarks, tmp_path):
    """Two ways to say it, of which one knows nothing of the other."""
    episode = drawn("compass", 5, landmarks)
    frames = [Frame(frame.time, frame.odometry, frame.measurements) for frame in episode.frames[:4]]
    given, suspects = read_back(tmp_path, episode, frames), suspected(frames, range(3), 3, 0.0)
    assert {suspect.who for suspect in suspects} == everybody(given, 3)
    assert {suspect.kind for suspect in suspects} == {"past", "compass", "sensor", "body", "sighting", "exchange"}
    for suspect in suspects:
        for change, mine in ((left_by, without), (both_left, without_both)):
            if change is both_left and suspect.kind != "exchange":
                continue
            left = [Frame(frame.time, frame.odometry, change(suspect, tuple(frame.measurements))) for frame in frames]
            for one, other in zip(read_back(tmp_path, episode, left), given, strict=True):
                assert said(one) == said(mine(other, suspect.who)), suspect


def both_left(suspect: Suspect, records):
    return _without_them([suspect], records)


def test_there_are_as_many_frames_as_the_tests_think(doubtful):
    assert len({record["t"] for record in lines_of(doubtful, ALTERNATIVES)}) == FRAMES - FIRST
