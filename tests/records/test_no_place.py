"""Positions that say nothing, as they have no half-plane, and some that nobody can be at, as theirs exclude one another."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.follow import main as follow_command
from experiments.logs import Header, InitialSet, LogReader, LogWriter
from filter import (
    AngularIntervals,
    Compass,
    ExtendedKalmanFilter,
    Frame,
    Inconsistent,
    Polygon,
    Position,
    Range,
    Sensor,
    SetMembershipFilter,
    Source,
    Team,
    position_from_range_difference,
)

TEAM = Team(["alice", "bob"], {"gate": [3.0, 0.0]}, speed_limit=1.0, arena=[[-50, -50], [50, 50]])
BOX = Polygon.box([-3, -3], [3, 3])
ANCHORS = [[-20.0, 0.0], [20.0, 0.0]]


def nothing(time=0.0):
    """Return a position of nobody, in no half-plane."""
    return Position(time, [], [], [], [])


def nowhere(time=0.0, robot=1, gap=1.0, way=0.0, sensor=-1):
    """Return two half-planes that turn their backs on one another, so far apart."""
    x, y = np.array([1.0, -1.0]) * np.cos(way), np.array([1.0, -1.0]) * np.sin(way)
    return Position(time, robot, x, y, [0.5, -0.5 - gap], sensor)


def corner():
    """Return three half-planes, of which each two have something in common."""
    turns = 2 * np.pi * np.arange(3) / 3
    return Position(0.0, 1, np.cos(turns), np.sin(turns), -0.5)


def of_no_difference():
    """Return what is left where no place has the difference that was measured."""
    return position_from_range_difference(0.0, 1, ANCHORS, 39.9, 0.01, BOX)


def begun(filter_):
    return filter_.start(0.0, [BOX, BOX], AngularIntervals([0.0, 0.0], [0.1, 0.1]))


def updated(records, **options):
    filter_ = SetMembershipFilter(TEAM, **options)
    return filter_.update(begun(filter_), records)


IMPOSSIBLE = {
    "two": nowhere(),
    "aslant": nowhere(way=2.0),
    "by little": nowhere(gap=1e-6),
    "three": corner(),
    "far away": Position(0.0, 1, [1.0, -1.0], 0.0, [-1e9, 1e9 - 1.0]),
    "no difference": of_no_difference(),
}
impossible = pytest.mark.parametrize("record", IMPOSSIBLE.values(), ids=IMPOSSIBLE)


@pytest.mark.parametrize("record", [nothing(), position_from_range_difference(0.0, 1, ANCHORS, 0.0, 40.0, BOX)])
def test_no_half_plane_says_nothing(record):
    assert len(record.offset) == 0
    alone, beside = updated([record]), updated([record, Position.fix(0.0, 0, [0.0, 0.0], 0.1)])
    assert alone.regions.outer.areas.tolist() == updated([]).regions.outer.areas.tolist()
    assert beside.regions.outer.areas == pytest.approx([0.04, 36.0], rel=1e-5)


@pytest.mark.parametrize("exact", [True, False])
@impossible
def test_a_position_that_nobody_can_be_at_is_a_conflict_by_itself(record, exact):
    with pytest.raises(Inconsistent) as caught:
        updated([Compass(0.0, [0, 1], 0.0, 0.1), record, Range(0.0, 0, 1, 2.0, 0.1, 0.0)], exact=exact)
    assert caught.value.sources == (Source("position", 0.0, 1),)


@impossible
def test_it_is_rejected_alone_and_the_rest_stays(record):
    seen = [Position.fix(0.0, 0, [0.0, 0.0], 0.1), Range(0.0, 0, 1, 2.0, 0.1, 0.0), Compass(0.0, [0, 1], 0.0, 0.1)]
    belief, without = updated([*seen, record], policy="reject"), updated(seen)
    told = "in doubt since 0.000 s: sensor of bob; in conflict: position of bob at 0.000 s"
    assert [event.named(TEAM) for event in belief.events] == [told, "guilty, by proof: sensor of bob"]
    assert str(belief.guarantee) == "in force if nothing is wrong but: sensor of bob"
    assert belief.guarantee.in_force.all()
    assert belief.regions.outer.areas.tolist() == without.regions.outer.areas.tolist()


def test_where_two_say_what_cannot_be_both_start_over():
    belief = updated([nowhere(), nowhere(robot=0), nothing()], policy="reject")
    (event,) = belief.events
    assert event.robots == (0, 1)
    assert belief.guarantee.lapsed.all()
    assert belief.regions.outer.areas == pytest.approx([1e4, 1e4])


@pytest.mark.parametrize("fixes", [[nowhere(1.0)], [Position.fix(1.0, 1, [x, 0.0], 0.1) for x in (-1.0, 1.0)]])
@pytest.mark.parametrize("policy", ["raise", "reject"])
def test_among_several_instants_it_is_found_too_although_what_moves_since_makes_room_for_it(policy, fixes):
    filter_ = SetMembershipFilter(TEAM, policy=policy)
    frames = [Frame(0.5, None, [nothing(0.5)]), Frame(1.0, None, fixes), Frame(3.0, None, [nothing(3.0)]), Frame(3.5)]
    if policy == "raise":
        with pytest.raises(Inconsistent) as caught:
            filter_.advance(begun(filter_), frames)
        assert set(caught.value.sources) == {Source("position", 1.0, 1)}
        return
    belief = filter_.advance(begun(filter_), frames)
    doubted, judged = belief.events
    assert set(doubted.conflict) == {Source("position", 1.0, 1)}
    assert (judged.verdict, judged.suspect.who) == ("guilty", ("sensor", 1, -1))
    assert [suspect.who for suspect in belief.aside] == [("sensor", 1, -1)]
    assert belief.guarantee.in_force.all()


def test_positions_of_several_instants_and_robots_are_not_taken_together():
    """What is two places at once for one robot at one instant is none for two, nor for one that has moved."""
    west, east = [-1.0, 0.0], [1.0, 0.0]
    fixes = [Position.fix(time, robot, at, 0.1) for time, robot, at in ((1.0, 0, west), (1.0, 1, east), (4.0, 0, east))]
    frames = [Frame(time, None, [fix for fix in fixes if fix.time == time]) for time in (1.0, 4.0)]
    phases = []
    filter_ = SetMembershipFilter(TEAM, on_phase=phases.append)
    belief = filter_.advance(begun(filter_), frames)
    assert phases.count("project") == 1, "all instants were merged at once"
    assert belief.regions.contains(np.array([east, west])).all()
    assert belief.regions.outer.areas[0] == pytest.approx(0.04, rel=1e-5)


def test_events_of_all_instants_are_told():
    filter_ = SetMembershipFilter(TEAM, policy="reject")
    frames = [Frame(time, None, [nowhere(time)]) for time in (1.0, 2.0)] + [Frame(3.0)]
    belief = filter_.advance(begun(filter_), frames)
    assert [event.time for event in belief.events] == [1.0, 1.0]  # at 2.0 it is not listened to any more
    apart = [replace(frame, measurements=[nowhere(frame.time, k)]) for k, frame in enumerate(frames[:2])]
    assert [event.time for event in filter_.advance(begun(filter_), apart).events] == [1.0, 1.0, 2.0, 2.0]
    assert filter_.advance(belief, []) is belief


@given(st.floats(-np.pi, np.pi), st.floats(1e-6, 100.0), st.floats(-40, 40), st.floats(-40, 40))
def test_however_it_is_turned_and_wherever_nobody_is_there(way, gap, x, y):
    """Seen from anywhere the two half-planes exclude one another, and a third that both allow does not help."""
    across = np.array([np.cos(way), np.sin(way)])
    at = float(across @ [x, y])
    record = Position(0.0, 1, [across[0], -across[0]], [across[1], -across[1]], [at, -at - gap])
    with pytest.raises(Inconsistent, match=r"all of: position of robot 1 at 0\.000 s$"):
        updated([record], cells=0)


def test_to_a_kalman_filter_it_says_nothing():
    kalman = ExtendedKalmanFilter(TEAM)
    begin = begun(kalman)
    clear = [record for name, record in IMPOSSIBLE.items() if name != "by little"]  # to it, that is touching
    for record in (nothing(), *clear):
        after = kalman.update(begin, [record])
        assert (after.mean == begin.mean).all()
        assert (after.covariance == begin.covariance).all()


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "own.jsonl"
    with LogWriter(path, Header(TEAM, 0.0), [InitialSet(BOX.vertices)] * 2) as writer:
        for time, records in ((0.0, [nothing()]), (1.0, [nowhere(1.0)]), (2.0, [Position.fix(2.0, 1, [0.0, 0.0], 0.5)])):
            writer.write(Frame(time, None, records))
    return path


def test_a_log_brings_both_back_as_they_were(log):
    records = [record for frame in LogReader(log).frames() for record in frame.measurements]
    assert [len(record.offset) for record in records] == [0, 2, 4]
    assert (records[1].normals == nowhere().normals).all()


@pytest.mark.parametrize("every", ["0", "3"])
def test_a_run_names_it_and_stops(log, tmp_path, every):
    assert follow_command([str(log), "--out", str(tmp_path), "--every", every]) == 1
    told = json.loads((tmp_path / "summary.json").read_text())["inconsistent"]
    assert told == "at 1.0 s: no configuration satisfies all of: position of bob at 1.000 s"


def test_a_run_goes_on_without_it_and_says_so(log, tmp_path):
    assert follow_command([str(log), "--out", str(tmp_path), "--policy", "reject", "--every", "3"]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["doubts"], summary["put_aside"], summary["guarantee_in_force"]) == (1, "sensor of bob", True)


def test_of_a_case_that_ends_by_positions_alone_there_is_no_certificate(log, tmp_path, capsys):
    assert follow_command([str(log), "--out", str(tmp_path), "--policy", "reject", "--certificates"]) == 2
    assert "in which it is proved of each case why it cannot be" in " ".join(capsys.readouterr().err.split())


ANTENNAS = Team(
    2,
    arena=TEAM.arena,
    speed_limit=1.0,
    sensors=[Sensor("mast", [2.0, 0.0]), Sensor("twin", [-2.0, 0.0]), Sensor("late", [2.0, 0.0], time_bound=0.5)],
)


def at_antennas(records, policy="raise"):
    filter_ = SetMembershipFilter(ANTENNAS, policy=policy)
    return filter_.update(filter_.start(0.0, [BOX, BOX]), records)


@pytest.mark.parametrize("sensor", [0, 1])
def test_an_antenna_that_is_nowhere_is_found_though_the_heading_is_unknown(sensor):
    """As far as the centre goes, two metres of arm make room between the two half-planes."""
    with pytest.raises(Inconsistent) as caught:
        at_antennas([nowhere(sensor=sensor), Compass(0.0, 0, 0.0, 0.1)])
    assert caught.value.sources == (Source("position", 0.0, 1, sensor=sensor),)
    fixes = [Position.fix(0.0, 1, [x, 0.0], 0.1, sensor) for x in (-0.5, 0.5)]
    with pytest.raises(Inconsistent) as caught:
        at_antennas(fixes)
    assert caught.value.sources == (Source("position", 0.0, 1, sensor=sensor),) * 2
    belief = at_antennas([nowhere(sensor=sensor), fixes[0]], "reject")
    assert belief.events[0].conflict == (Source("position", 0.0, 1, sensor=sensor),)
    assert (belief.regions.outer.areas == at_antennas([]).regions.outer.areas).all()


def test_two_antennas_are_at_two_places_and_one_whose_clock_is_off_was_at_two_instants():
    west, east = [-0.5, 0.0], [0.5, 0.0]
    apart = [Position.fix(0.0, 1, west, 0.1, 0), Position.fix(0.0, 1, east, 0.1, 1)]
    late = [Position.fix(0.0, 1, place, 0.1, 2) for place in (west, east)]
    others = [Position.fix(0.0, robot, place, 0.1, 0) for robot, place in ((0, west), (1, east))]
    for records in (apart, late, others):
        assert at_antennas(records).guarantee.in_force.all()


@pytest.mark.parametrize("gap", [0.0, 1e-9])
def test_half_planes_that_touch_or_are_apart_by_rounding_leave_a_line(gap):
    belief = updated([nowhere(gap=gap)])
    assert belief.regions[1].outer.area < 1e-6
    assert belief.regions[1].outer.contains([0.5, 0.0]) or gap
    assert at_antennas([nowhere(gap=gap, sensor=0)]).guarantee.in_force.all()


@pytest.mark.parametrize("far", [1e4, 5e6, 1e10])
def test_far_from_the_origin_nobody_is_taken_to_be_nowhere(far):
    team = Team(1, sensors=[Sensor("mast", [2.0, 0.0])])
    filter_, place = SetMembershipFilter(team), np.array([far, -far])
    belief = filter_.start(0.0, [Polygon.box(place - 3, place + 3)])
    for sensor in (-1, 0):
        records = [Position.fix(0.0, 0, place, 0.5, sensor), Position.disc(0.0, 0, place, 0.5, 16, sensor)]
        assert filter_.update(belief, records).regions[0].outer.contains(place)
