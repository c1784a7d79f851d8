"""Where robots start over the proof goes on: they are anywhere, apart from all others, until they are in force again."""

import json
import re
import shutil
from copy import deepcopy
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from helpers.drawn.broken import drawn, outside
from helpers.proved.doubts import proved, read_back, refusal, said, written
from helpers.proved.restarts import AT_ONCE, IN_DOUBT, lying_team
from helpers.proved.runs import forge, lines_of, moved

from experiments import prove
from experiments.follow import main as follow_command
from experiments.logs import Header, InitialSet, LogWriter
from experiments.logs.alternatives import Alternatives
from experiments.proof.alternatives.doubts import IN_FORCE, WAITING, Cover, Doubts
from experiments.proof.alternatives.wrong import without_robots, without_ties
from experiments.proof.chain import Chain
from experiments.proof.edges import WORLD
from experiments.proof.exact import ANYWHERE
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken, Feed
from experiments.proof.recording.told import Told
from experiments.proof.share import Share
from experiments.proof.shown import Region
from experiments.prove import ALTERNATIVES, HEADINGS, LINES, SUMMARY
from filter import Frame, InvalidInput, Left, Odometry, Polygon, Position, SetMembershipFilter, StartsOver, Step, Team
from filter.diagnosis import evidence, told


def run_of(path, lies, count):
    """Return the folder of a run in which robots start over, and are in force again by little evidence."""
    header, initial, frames = lying_team(lies, count)
    filter_ = SetMembershipFilter.light(header.team, policy="reject", cells=0, each_alone=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evidence, "INSTANTS", 9)
        patch.setattr(evidence, "OFTEN", 5)
        beliefs = written(path, filter_, header, initial, frames)
    for belief, frame in zip(beliefs, frames, strict=True):
        assert not outside(belief, frame.truth).any()
    return path


@pytest.fixture(scope="module")
def over(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("over"), IN_DOUBT, 9)


@pytest.fixture(scope="module")
def at_once(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("at_once"), AT_ONCE, 8)


def over_in(records):
    return [record for record in records if "over" in record]


def on_trust(time, *robots):
    return f"on trust: what is wrong at t = {time} s is of none but those who start over: {', '.join(robots)}"


def test_it_is_proved_and_says_on_what_it_rests(over):
    (record,) = over_in(lines_of(over, ALTERNATIVES))
    assert record["over"] == [0, 1]
    assumed, _ = proved(over)
    assert assumed[on_trust(0.2, "r0", "r1")] == 2
    assert assumed[IN_FORCE] == 2
    assert assumed["on trust: from t = 0.5 s on nothing is wrong but: sensor r2"] == 1  # who lied while they were waiting
    assert assumed[WAITING] == 12


def test_where_nothing_was_in_doubt_and_again_it_is_proved(at_once):
    for record in over_in(lines_of(at_once, ALTERNATIVES)):
        assert not record["lines"]
    assumed, _ = proved(at_once)
    for time in (0.1, 0.2):
        assert assumed[on_trust(time, "r0", "r1", "r2")] == 3
    assert [proved(at_once, Share(number, 2))[0] for number in range(2)] == [assumed] * 2


def nothing_is_told_of_it(records):
    records[:] = over_in(records)


def one_is_so_twice(records):
    records[-1]["confirmed"].append(2)


@pytest.mark.parametrize(
    ("change", "why"),
    [(nothing_is_told_of_it, "is not proved"), (one_is_so_twice, "somebody is in force again who has not started over")],
)
def test_only_of_who_is_in_force_again_counts_what_ties_it_to_others(change, why, at_once, tmp_path):
    copy = Path(shutil.copytree(at_once, tmp_path / "copy"))
    forge(copy, ALTERNATIVES, change)
    assert why in refusal(copy)


def test_it_is_proved_from_the_command_line(tmp_path, capsys):
    header, initial, frames = lying_team(AT_ONCE, 3)
    with LogWriter(tmp_path / "log.jsonl", header, initial) as log:
        for frame in frames:
            log.write(frame)
    how = ["--policy", "reject", "--light", "--certificates", "--out", str(tmp_path / "run")]
    assert follow_command([str(tmp_path / "log.jsonl"), *how]) == 4
    assert prove.main([str(tmp_path / "run")]) == 0
    assert f"6 {WAITING}" in capsys.readouterr().out


FORGED = {}


def forged(why):
    """Enter a function that changes the records of alternatives of a step in place, with the reason of the refusal."""

    def entered(change):
        FORGED[change.__name__] = (change, why)
        return change

    return entered


@forged("the heading of robot 2 is not proved")
def who_starts_over_is_where_it_was(records):
    over_in(records)[0]["over"] = [0, 1, 2]


@forged("nobody starts over")
def nobody_starts_over(records):
    over_in(records)[0]["over"] = []


@forged("ends without a proof")
def that_robots_start_over_is_not_told(records):
    records.remove(over_in(records)[0])


@forged("where an alternative has edges 0.001 m farther out")
def what_the_others_go_on_from_is_smaller(records):
    line = over_in(records)[0]["lines"][-1]
    line["offset"] = moved(line["offset"], -0.001)


@forged("a heading of the cover is narrower than that of an alternative")
def what_the_others_look_from_is_narrower(records):
    (heading,) = over_in(records)[0]["headings"]
    heading["bound"][2] = (float.fromhex(heading["bound"][2]) * (1 - 1e-6)).hex()


@pytest.fixture(scope="module")
def in_doubt(over):
    """Return what has checked the steps before robots start over, and the feeds for the next ones."""
    doubts, feeds = Doubts(Log(over)), [Feed(over / name) for name in (HEADINGS, LINES, ALTERNATIVES)]
    for frame in doubts._log.frames[:2]:
        doubts.check(*(feed.at(frame.time, least=0) for feed in feeds))
    doubts._log.rest = iter(())  # what is read in passing cannot be copied
    return doubts, [feed.at(doubts._log.frames[2].time) for feed in feeds]


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_start_is_refused(name, in_doubt):
    (doubts, (headings, lines, told)), (change, why) = deepcopy(in_doubt), FORGED[name]
    records = [record for _, record in told]
    change(records)
    with pytest.raises(Broken, match=re.escape(why)):
        doubts.check(headings, lines, [("", record) for record in records])


@pytest.mark.parametrize(
    ("claims", "why"),
    [({"guarantee_in_force": True}, "though robots have started over"), ({"escapes_in_force": 1}, "where 0 were outside")],
)
def test_of_a_guarantee_that_was_suspended_the_summary_says_so(claims, why, over, tmp_path):
    summary = {"guarantee_in_force": False, "escapes_in_force": 0, "rejected": 0} | claims
    (tmp_path / SUMMARY).write_text(json.dumps(summary) + "\n")
    held = Told(Log(over), _suspended=True)
    held.numbers = lambda: {}
    with pytest.raises(Broken, match=why):
        held.check_summary(tmp_path / SUMMARY)


def test_what_is_outside_while_nothing_is_promised_breaks_no_promise(over):
    log = Log(over)
    frame = log.frames[0]
    edges = {(WORLD, robot): {(Fraction(1), Fraction(0)): frame.truth[robot][0][0] - 1} for robot in range(3)}
    cover = Cover([ANYWHERE] * 3, edges)
    held = Told(log)
    region = Region([], 0.0, (Fraction(0), Fraction(0)))
    held.add(frame, [region, None, region], cover, {0, 1})
    assert (held._escapes, held._held, held._suspended) == (2, 1, True)


def test_before_several_cases_were_one_nothing_branches_off(over):
    """It would be what was known in one of them alone."""
    chain = Chain(Log(over))
    chain._begin(chain._log.frames[0])
    begun = chain.begun(chain.headings, {})
    assert begun.branch(1).frames == 1
    assert chain.branch(0).frames == 0
    with pytest.raises(Broken, match="before several cases were one"):
        begun.branch(0)


@pytest.mark.parametrize(("change", "mine"), [(told.without_robots, without_robots), (told.without_ties, without_ties)])
def test_what_counts_of_those_who_start_over_is_as_in_the_filter(change, mine, tmp_path):
    """Two ways to say it, of which one knows nothing of the other."""
    episode = drawn("compass", 5)
    frames = [Frame(frame.time, frame.odometry, frame.measurements) for frame in episode.frames[:3]]
    count = [3] if mine is without_ties else []
    for robots in ({1}, {0, 2}):
        left = [Frame(frame.time, frame.odometry, change(robots, *count, tuple(frame.measurements))) for frame in frames]
        for one, other in zip(read_back(tmp_path, episode, left), read_back(tmp_path, episode, frames), strict=True):
            assert one != other
            assert said(one) == said(mine(other, robots, *count))


def test_robots_that_have_all_left_the_arena_are_anywhere_in_it(tmp_path):
    team = Team(2, arena=[[-4.0, -4.0], [4.0, 4.0]])
    sets = [InitialSet(np.array([[x, 0.0], [x + 1, 0.0], [x, 1.0]]), (0.0, 0.1)) for x in (0.0, 2.0)]
    frames = [out_at(2.0, time) for time in (0.0, 1.0, 2.0, 3.0)]
    filter_ = SetMembershipFilter.light(team, policy="reject", cells=0, each_alone=True)
    beliefs = written(tmp_path, filter_, Header(team, 0.0, 1.0, version=2), sets, frames)
    assert beliefs[-1].guarantee.lapsed.all()
    (record,) = lines_of(tmp_path, ALTERNATIVES)
    assert record["over"] == [0, 1]
    assert proved(tmp_path)[0][WAITING] == 4


def out_at(when, time):
    """Return a frame in which two robots are where they were, though at one time both have driven far away."""
    far = 20.0 if time == when else 0.0
    odometry = Odometry(time - 1, time, [0, 1], far, 0.01, 0.0, 0.01, 0.01, 0.01) if time else None
    return Frame(time, odometry, [Position.fix(time, robot, [2.0 * robot + 0.3, 0.3], 0.5) for robot in range(2)])


@pytest.mark.parametrize(
    ("reach", "why"), [(np.inf, "in a closed arena"), (4.0, "nobody comes or leaves as a doubt ends in robots that start over")]
)
def test_there_are_no_certificates_in_an_open_arena_or_where_somebody_leaves_in_a_doubt(reach, why):
    team = Team(2, arena=[[-reach, -reach], [reach, reach]])
    belief = SetMembershipFilter(team).start(0.0, [Polygon.box([0.0, 0.0], [1.0, 1.0])] * 2)
    alternatives = Alternatives(team)
    alternatives._doubtful = belief
    over = replace(belief, events=(StartsOver(0.0, (0,), ()),))
    with pytest.raises(InvalidInput, match=why):
        alternatives.of(Step(Frame(0.0, changes=[Left(0.0, 1)]), belief, over, 0.0))
