"""Faults: what counts as right and as broken, who is named, and the command with filters that are honest, deaf or blind."""

import csv
import json
from concurrent.futures import Future
from contextlib import nullcontext
from dataclasses import dataclass, replace

import numpy as np
import pytest

from experiments import faults
from experiments.broken import outcome
from experiments.broken.episodes import NEVER
from experiments.broken.fault import KINDS, Fault
from experiments.broken.figures import HONEST, RIGHT, WRONG, fate
from experiments.broken.named import innocents, named_by, names_the_culprit
from experiments.broken.outcome import SOON, Case, Moment, first_provable, judged, outcome_of, steps_of
from experiments.broken.told import sentence, summary_of
from filter import Inconsistent, SetMembershipFilter

SLIP = Fault("slip", 3, 4.0, below=False, robot=0, offset=(1.0, 0.0))
BIASED = Fault("biased", 3, np.inf, below=False, robot=1, turn=0.5)
GOOD, LOST, MUTE, HONESTLY_LOST = "good", "lost", "mute", "honestly lost"
NAMED, SLANDER = "named", "slander"
AREA = {MUTE: 7.0, HONESTLY_LOST: 9.0}


def moment(what):
    outside = np.array([False, what in (LOST, HONESTLY_LOST), False])
    in_force = np.array([True, what not in (MUTE, HONESTLY_LOST), True])
    return Moment(outside, in_force, what == NAMED, what == SLANDER, AREA.get(what, 0.1))


def verdict(fault, *moments, frames=None, provable=None):
    said = [moment(each) for each in moments]
    return judged(fault, said, len(said) if frames is None else frames, provable)


def test_a_truth_outside_in_force_counts_from_the_first_frame_on_in_which_that_could_be_known():
    told = [GOOD, GOOD, GOOD, LOST, LOST, LOST, HONESTLY_LOST, GOOD]
    for provable, after, before in ((3, 3, 0), (4, 2, 1), (6, 0, 3), (None, 0, 3)):
        found = verdict(SLIP, *told, provable=provable)
        assert (found.outside_in_force, found.outside_before) == (after, before)


def test_nothing_excuses_what_is_wrong_before_the_fault():
    found = verdict(SLIP, LOST, MUTE, GOOD, GOOD, GOOD)
    assert (found.outside_in_force, found.outside_before, found.without_cause) == (1, 0, 1)
    ended = verdict(SLIP, GOOD, GOOD, frames=9)
    assert ended.gave_up
    assert ended.outside_in_force == 1


def test_right_is_in_force_and_inside_soon_and_in_the_end():
    early, late = [GOOD] * 4, [GOOD] * 4
    assert verdict(SLIP, *early, *[MUTE] * SOON, *late).right
    assert verdict(SLIP, *early, *[MUTE] * SOON, *late).first_right == SOON
    assert not verdict(SLIP, *early, *[MUTE] * (SOON + 1), *late).right
    assert not verdict(SLIP, *early, *late, MUTE).right
    assert not verdict(SLIP, *early, *late, LOST).right
    assert not verdict(SLIP, *early, *late, SLANDER).right
    assert not verdict(SLIP, *early, *late, frames=40).right
    never = verdict(SLIP, *early, *[HONESTLY_LOST] * 9)
    assert (never.right, never.first_right) == (False, None)


def test_areas_are_those_before_the_fault_where_they_are_largest_and_in_the_end():
    found = verdict(SLIP, HONESTLY_LOST, GOOD, GOOD, GOOD, MUTE, GOOD)
    assert (found.area_before, found.area_most, found.area_end) == (0.1, 7.0, 0.1)
    at_once = verdict(replace(SLIP, kind="start", when=0, until=1.0), MUTE, HONESTLY_LOST)
    assert (at_once.area_before, at_once.area_most, at_once.area_end) == (None, 9.0, 9.0)
    assert verdict(SLIP, frames=9).area_end is None


def test_of_what_lasts_the_culprit_has_to_be_named_and_frames_count_from_its_beginning():
    early = [GOOD] * 3
    assert not verdict(BIASED, *early, *[GOOD] * 20).right
    found = verdict(BIASED, *early, MUTE, *[NAMED] * 20)
    assert (found.right, found.first_right, found.named) == (True, 1, True)
    assert not verdict(BIASED, *early, *[NAMED] * 20, GOOD).right


@dataclass
class Suspect:
    kind: str
    robot: int
    target: int
    since: float = 0.0


@dataclass
class Belief:
    aside: tuple[Suspect, ...] = ()


SWAP = Fault("swap", 3, np.inf, below=False, robot=0, body=2)
MISREAD = Fault("misread", 3, 5.0, below=False, robot=0, body=2, read=4)
MOVED = Fault("moved", 3, np.inf, below=False, body=4, offset=(1.0, 0.0))
COMPASS = Fault("compass", 3, 9.0, below=False, robot=2, turn=1.0)


@pytest.mark.parametrize(
    ("fault", "suspects", "named", "slandered"),
    [
        (SLIP, [("past", 0, -1)], True, 0),
        (SLIP, [("past", 1, -1)], False, 1),
        (SLIP, [("sensor", 0, -1)], False, 1),
        (COMPASS, [("compass", 2, -1)], True, 0),
        (COMPASS, [("compass", 2, -1), ("compass", 0, -1)], True, 1),
        (BIASED, [("sensor", 1, -1)], True, 0),
        (BIASED, [("sighting", 1, 4), ("sighting", 1, 0)], False, 0),
        (BIASED, [("body", -1, 1)], False, 1),
        (MOVED, [("body", -1, 4)], True, 0),
        (MOVED, [("sighting", 0, 4)], False, 0),
        (MOVED, [("body", -1, 3)], False, 1),
        (SWAP, [("exchange", 2, 0)], True, 0),
        (SWAP, [("exchange", 0, 1)], False, 1),
        (SWAP, [("body", -1, 0), ("body", -1, 2)], True, 0),
        (SWAP, [("body", -1, 2)], False, 0),
        (SWAP, [("sighting", 1, 2), ("sighting", 1, 3)], False, 1),
        (MISREAD, [("sighting", 0, 4)], True, 0),
        (MISREAD, [("sighting", 0, 3)], False, 1),
        (SLIP, [], False, 0),
    ],
)
def test_who_is_named_is_held_against_who_it_was(fault, suspects, named, slandered):
    said = named_by(Belief(tuple(Suspect(*each) for each in suspects)))
    assert names_the_culprit(fault, said) == named
    assert len(innocents(fault, said)) == slandered


def test_a_belief_that_names_nobody_has_named_nobody():
    assert named_by(object()) == frozenset()


def some(fault, **different):
    return replace(verdict(fault, *[GOOD] * 3, *[NAMED if fault.lasts else GOOD] * 20, provable=3), **different)


def test_shares_are_of_large_faults_and_small_ones_are_told_apart():
    small = replace(SLIP, below=True)
    outcomes = [some(SLIP), some(SLIP, right=False), some(small, right=False, provable=None), some(BIASED)]
    found = summary_of(4, 0, outcomes)
    assert found["kinds"] == ["slip", "biased"]
    assert (found["episodes"], found["episodes_below"]) == (4, 1)
    assert found["right_share"] == pytest.approx(2 / 3, abs=1e-6)
    assert found["right_share_by_kind"] == {"slip": 0.5, "biased": 1.0}
    assert (found["right_share_below"], found["right_share_below_by_kind"]) == (0.0, {"slip": 0.0})
    assert (found["share_proved"], found["share_proved_below"]) == (1.0, 0.0)
    assert (found["area_before_median_m2"], found["area_most_median_m2"]) == (0.1, 0.1)
    assert (found["culprit_named_share"], found["frames_until_right_median"]) == (1.0, 0.0)
    assert summary_of(4, 0, [some(small)])["right_share"] is None


def test_an_episode_has_one_fate_and_being_wrong_counts_first():
    assert [fate(some(SLIP)), fate(some(SLIP, right=False)), fate(some(SLIP, outside_in_force=1))] == [RIGHT, HONEST, WRONG]
    assert "No truth was outside" in sentence([some(SLIP)])
    assert "In 1 of 2 episodes, 7 frames" in sentence([some(SLIP), some(SLIP, outside_in_force=7)])


class Deaf:
    """Listens to nobody from the first disagreement on, and says nothing of it."""

    def __init__(self, team):
        self.strict, self.listens = SetMembershipFilter(team), True
        self.start, self.predict = self.strict.start, self.strict.predict

    def update(self, belief, measurements=()):
        try:
            return self.strict.update(belief, measurements) if self.listens else belief
        except Inconsistent:
            self.listens = False
            return belief


def test_a_filter_that_says_nothing_is_caught(monkeypatch):
    monkeypatch.setattr(outcome, "filter_for", lambda episode: Deaf(episode.team))
    found = outcome_of(large("kidnap"))
    assert found.provable == found.fault.when
    assert found.outside_in_force > 5
    assert (found.right, found.outside_before, found.without_cause) == (False, 0, 0)


def test_a_filter_that_gives_up_is_honest_and_not_right(monkeypatch):
    monkeypatch.setattr(outcome, "filter_for", lambda episode: SetMembershipFilter(episode.team))
    found = outcome_of(large("slip"))
    assert found.gave_up
    assert (found.right, found.outside_in_force, found.outside_before, found.without_cause) == (False, 0, 0, 0)
    assert found.provable == found.fault.when


def large(kind):
    """Return an episode with a large fault."""
    return next(case for case in (Case(0, kind, number, 4) for number in range(50)) if not case.episode().fault.below)


def test_what_is_proved_needs_the_steps_before_the_fault():
    episode = large("slip").episode()
    assert episode.fault is not NEVER
    steps = list(steps_of(episode, SetMembershipFilter(episode.team)))
    assert len(steps) == episode.fault.when
    assert first_provable(episode, steps) == episode.fault.when
    assert first_provable(episode, steps[:-1]) is None


class Here:
    """An executor that computes in this process, at once."""

    def submit(self, task, case):
        future = Future()
        future.set_result(task(case))
        return future


@pytest.mark.parametrize("deaf", [True, False])
def test_the_exit_code_is_the_guarantee(monkeypatch, tmp_path, deaf, capsys):
    kind = (lambda episode: Deaf(episode.team)) if deaf else (lambda episode: SetMembershipFilter(episode.team))
    monkeypatch.setattr(outcome, "filter_for", kind)
    monkeypatch.setattr(faults, "executor", lambda workers: nullcontext(Here()))
    code = faults.main(["--episodes", "8", "--out", str(tmp_path)])
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert code == int(summary["outside_in_force"] > 0) == int(deaf)
    assert summary["kinds"] == list(KINDS)
    assert summary["episodes"] == 8
    assert summary["gave_up"] == 0 if deaf else summary["gave_up"] > 4
    rows = list(csv.DictReader((tmp_path / "episodes.csv").read_text().splitlines()))
    assert [row["kind"] for row in rows] == list(KINDS)
    assert sum(int(row["outside_in_force"]) for row in rows) == summary["outside_in_force"]
    assert (tmp_path / "faults.png").stat().st_size > 10_000
    assert "guarantee was said to be" in capsys.readouterr().out


def test_the_same_bytes_on_any_number_of_cores_with_a_recording(tmp_path):
    for workers in ("1", "2"):
        faults.main(["--episodes", "2", "--kinds", "misread", "--jobs", workers, "--out", str(tmp_path / workers)])
    one, two = ((tmp_path / workers) for workers in ("1", "2"))
    for name in ("summary.json", "episodes.csv", "faults.png"):
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_a_recording_of_one_episode_is_made_if_asked_for(monkeypatch, tmp_path):
    monkeypatch.setattr(faults, "executor", lambda workers: nullcontext(Here()))
    faults.main(["--episodes", "1", "--kinds", "misread", "--recording-of", "0", "--out", str(tmp_path)])
    assert (tmp_path / "episode_0.rrd").stat().st_size > 10_000


@pytest.mark.parametrize(
    "wrong",
    [
        ["--kinds", "flood"],
        ["--kinds", "slip,slip"],
        ["--episodes", "0"],
        ["--landmarks", "9"],
        ["--recording-of", "500"],
        ["--jobs", "0"],
    ],
)
def test_options_that_cannot_be_used_are_bad_input(wrong, tmp_path):
    assert faults.main([*wrong, "--out", str(tmp_path)]) == 2


def test_a_kind_has_the_same_episodes_whatever_other_kinds_there_are():
    some, every = faults.Options(episodes=2, kinds="swap"), faults.Options(episodes=16)
    assert faults.cases_of(some) == [case for case in faults.cases_of(every) if case.kind == "swap"]
