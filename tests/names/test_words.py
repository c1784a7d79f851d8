"""What a person reads names robots as their team does; where a team has none of its own, by those that stand for them."""

import copy
import pickle

import numpy as np
import pytest

from filter import (
    AngularIntervals,
    Confirmed,
    Doubted,
    Fallback,
    Guarantee,
    Inconsistent,
    InvalidInput,
    Judged,
    Late,
    Mistimed,
    Odometry,
    Passed,
    Polygon,
    Position,
    SetMembershipFilter,
    Source,
    StartsOver,
    Suspect,
    Team,
    Turned,
    watch,
)

MARKS = {"gate": [4.0, 0.0]}
NAMED, PLAIN = Team(["alice", "bob", "carol"], MARKS), Team(3, list(MARKS.values()))
SEEN, KNOWN = Source("bearing", 2.0, 1, 3), Source("region", 1.0, 0)
SQUARE = Polygon.box([0, 0], [1, 1])


def alarm(shift):
    (found,) = watch(SetMembershipFilter(NAMED).start(0.0, [SQUARE] * 3), [[0.5, 0.5], [1.5 + shift, 0.5], [0.5, 0.5]])
    return found


SAID = [
    (Suspect("past", 1), "odometry or start of bob"),
    (Suspect("compass", 1), "compass of bob"),
    (Suspect("sensor", 1), "sensor of bob"),
    (Suspect("body", None, 3), "place or marker of gate"),
    (Suspect("sighting", 1, 3), "what bob takes for gate"),
    (Suspect("exchange", 1, 2), "markers of bob and carol, exchanged"),
    (Doubted(2.0, 1.0, (SEEN,), (Suspect("sensor", 1),)), "in doubt since 1.000 s: sensor of bob; in conflict: bearing "),
    (Judged(2.0, Suspect("body", None, 3), "trusted again", "evidence"), "trusted again, by evidence: place or marker of gate"),
    (Passed(2.0, 1.0, (Suspect("sensor", 1),)), "in doubt no longer; wrong for a while since 1.000 s was one of: sensor "),
    (StartsOver(2.0, (0, 2), (SEEN,)), "starting over, guarantee suspended: alice, carol; more is wrong than one of: "),
    (Confirmed(2.0, 2), "carol is where it is said to be: guarantee in force again"),
    (Turned(9.0, 1, True, 0.3, 0.1, 4.0), "camera of bob suspected to be turned since 4 s: as bob drives, "),
    (Turned(9.0, 1, False, 0.3, 0.1, 4.0), "camera of bob trusted again at 9.000 s: as bob drives"),
    (Late(9.0, 1, True, 0.3, 0.1, 4.0), "camera of bob suspected to be late since 4 s: as bob turns, its pictures are stamped"),
    (Late(9.0, 1, False, 0.3, 0.1, 4.0), "camera of bob trusted again at 9.000 s: as bob turns"),
    (Fallback(1, ("walk",), "piqp", 0), "the region of bob seen from alice: no good answer of walk, piqp took over"),
    (Fallback(None, ("piqp",), None), "the deepest point: no good answer of piqp, nobody took over"),
    (
        Guarantee(np.array([2.0, np.inf, 2.0]), ("a lie", "", "a lie")),
        "suspended for alice, carol since 2.000 s, as a lie",
    ),
    (Guarantee.full(3), "in force"),
    (alarm(0.0), "the estimate of bob at 0.000 s is impossible by 0.500 m, proved by initial set of bob at 0.000 s"),
    (Inconsistent("at 1 s", [KNOWN, SEEN]), "at 1 s: no configuration satisfies all of: region of alice at 1.000 s; "),
    (Inconsistent("has left the arena by 1 s", [KNOWN], 0), "alice has left the arena by 1 s: "),
]  # fmt: skip


@pytest.mark.parametrize(("what", "words"), SAID)
def test_everything_that_is_said_has_the_names_of_the_team(what, words):
    assert what.named(NAMED).startswith(words)
    assert NAMED.words(what) == what.named(NAMED)
    assert "robot" not in NAMED.words(what)


@pytest.mark.parametrize("what", [what for what, _ in SAID])
def test_a_team_without_names_says_it_by_the_short_ones_of_recordings_and_files(what):
    words = NAMED.words(what)
    for name, short in zip(NAMED.names, PLAIN.names, strict=True):
        words = words.replace(name, short)
    assert PLAIN.words(what) == words


@pytest.mark.parametrize("what", [what for what, _ in SAID])
def test_as_text_it_is_said_by_numbers(what):
    assert not any(name in str(what) for name in (*NAMED.names, *PLAIN.names))


def test_what_names_nobody_is_said_as_it_is():
    event = Mistimed(1.0, 3.0, 2, False)
    assert NAMED.words(event) == PLAIN.words(event) == str(event)


@pytest.mark.parametrize("team", [Team(2, names=["r0", "r1"]), Team(["r0", "r1"]), Team(2, [[0, 0]]), Team(1)])
def test_names_that_are_the_numbers_are_none(team):
    assert not team.is_named


@pytest.mark.parametrize("team", [Team(2, {"gate": [0, 0]}), Team(["r1", "r0"]), Team(2, names=["r0", "bob"])])
def test_one_name_makes_a_team_that_has_names(team):
    assert team.is_named
    assert team.words(1) == team.name(1) == team.words(np.int64(1))


ARENA = Team(["alice", "bob"], arena=[[-2, -2], [2, 2]], speed_limit=0.0)


def far_east(robot):
    """Odometry of a robot that takes it out of the arena, whichever way it goes, if it looks east."""
    bounds = {"distance_bound": 0.0, "turn_bound": 0.0, "direction_bound": 0.0, "slip_bound": 0.0}
    return Odometry(0.0, 1.0, robot, 9.0, turn=0.0, **bounds)


def test_an_error_says_who_has_left_the_arena_also_after_it_was_copied():
    filter_ = SetMembershipFilter(ARENA)
    belief = filter_.start(0.0, [SQUARE, SQUARE], AngularIntervals([0.0, 0.0], [0.1, 0.1]))
    with pytest.raises(Inconsistent, match=r"robot 1 has left the arena by 1\.0 s: ") as caught:
        filter_.predict(belief, 1.0, far_east(1))
    assert ARENA.words(caught.value).startswith("bob has left the arena by 1.0 s: no configuration satisfies all of: ")
    assert "odometry of bob at 1.000 s" in ARENA.words(caught.value)
    assert caught.value.named(Team(2)).startswith("r1 has left the arena by 1.0 s: ")
    for again in (copy.copy(caught.value), pickle.loads(pickle.dumps(caught.value))):
        assert (again.robot, str(again), again.named(ARENA)) == (1, str(caught.value), caught.value.named(ARENA))


@pytest.mark.parametrize(("team", "who"), [(ARENA, "bob"), (Team(2, arena=ARENA.arena), "r1")])
def test_who_starts_outside_the_arena_is_named(team, who):
    with pytest.raises(InvalidInput, match=f"; came {who} wholly outside"):
        SetMembershipFilter(team).start(0.0, [SQUARE, Polygon.box([3, 3], [4, 4])])


def test_who_is_placed_outside_the_arena_is_named():
    filter_ = SetMembershipFilter(ARENA)
    with pytest.raises(InvalidInput, match="; came bob wholly outside"):
        filter_.placed(filter_.start(0.0, [SQUARE] * 2), 1, Polygon.box([3, 3], [4, 4]))


def test_what_a_guarantee_assumes_has_names():
    filter_ = SetMembershipFilter(ARENA, policy="reject")
    far = Position.within(0.0, 1, Polygon.box([1.5, 1.5], [1.9, 1.9]))
    guarantee = filter_.update(filter_.start(0.0, [SQUARE] * 2), [far]).guarantee
    told = "if only one of these is wrong since 0.000 s: odometry or start of bob; sensor of bob"
    assert guarantee.assuming == told
    assert ARENA.words(guarantee) == f"in force {told}"
