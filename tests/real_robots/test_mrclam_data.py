import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.mrclam_folder import BARCODE, CLOCK, HEAD, LANDMARKS, Made, write_run

from experiments.logs import initial_headings
from experiments.real_robots.bounds import DEGREE, Bounds, bound_over
from experiments.real_robots.data import read_run, read_tables, run_of
from experiments.real_robots.faults import FAULTS, faulty
from experiments.real_robots.frames import Start, frames, truth_at
from experiments.real_robots.motion import Motions
from filter import AngularIntervals, InvalidInput, Odometry, Range, wrap
from filter.sensing.motion import displacements

FILES = ["Barcodes.dat", "Landmark_Groundtruth.dat", "Robot1_Odometry.dat", "Robot1_Measurement.dat", "Robot2_Groundtruth.dat"]
REAL = os.environ.get("MRCLAM_RUN")  # the folder of a run of the real data set
needs_data = pytest.mark.skipif(REAL is None, reason="MRCLAM_RUN names no folder of the real data set")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("data") / "made", Made(robots=3))


@pytest.fixture(scope="module")
def run(folder):
    return read_run(folder)


@pytest.fixture
def own(tmp_path):
    """A folder to be spoilt."""
    return write_run(tmp_path / "own", Made(duration=2.0))


def append(path, text):
    path.write_text(path.read_text() + text)


def same(one, other):
    return all(
        np.array_equal(getattr(one.logs[k], name), getattr(other.logs[k], name))
        for k in one.logs
        for name in ("commands", "measurements", "truth")
    )


def test_a_run_has_what_its_files_say(run, folder):
    assert sorted(run.logs) == [1, 2, 3]
    assert run.epoch == CLOCK
    np.testing.assert_array_equal(run.landmarks, [(k, *place) for k, place in LANDMARKS.items()])
    written = np.loadtxt(folder / "Robot2_Measurement.dat")
    subjects = {barcode: subject for subject, barcode in BARCODE.items()}
    np.testing.assert_allclose(run.logs[2].measurements[:, 0], written[:, 0] - CLOCK, atol=1e-6)
    assert run.logs[2].measurements[:, 1].tolist() == [subjects[int(barcode)] for barcode in written[:, 1]]
    np.testing.assert_array_equal(run.logs[2].measurements[:, 2:], written[:, 2:])
    assert set(vars(run.dropped).values()) == {0}


@pytest.mark.parametrize("name", [name for name in FILES if "Groundtruth" not in name or "Landmark" in name])
def test_a_missing_file_is_named(own, name):
    (own / name).unlink()
    if name == "Robot1_Odometry.dat":
        (own / "Robot2_Odometry.dat").unlink()
        name = "Robot<k>_Odometry.dat"
    with pytest.raises(InvalidInput, match=name):
        read_run(own)


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("line", ["1 2", "1.0 nan 3 4 5", "what is this", "1e999 1 1 1 1", "1 2 3 4 5 6", "1,2,3,4"])
def test_a_damaged_line_is_named_with_its_file(own, name, line):
    lines = (own / name).read_text().splitlines(keepends=True)
    if line == "1 2" and name == "Barcodes.dat":
        line = "1"
    (own / name).write_text("".join([*lines[:6], f"{line}\n", *lines[6:]]))
    with pytest.raises(InvalidInput, match=f"{name}, line 7: "):
        read_run(own)


@pytest.mark.parametrize("rest", [" 1248444009.5 \t 0.1", "1248444009.5 72 1.2 0.3", "12", "1248444009.5 72 1.2 0.3 9 "])
def test_a_last_line_that_is_cut_off_is_normal_and_counted(own, rest):
    before = read_run(own)
    append(own / "Robot1_Measurement.dat", rest)
    after = read_run(own)
    assert after.dropped == replace(before.dropped, cut_lines=1)
    assert same(before, after)


def test_an_end_is_not_missed_in_a_table_that_was_not_logged(own):
    for name in FILES[:2]:
        (own / name).write_text((own / name).read_text().rstrip("\n"))
    assert len(read_run(own).landmarks) == len(LANDMARKS)
    assert read_run(own).dropped.cut_lines == 0


def test_measurements_that_cannot_be_are_dropped_and_counted(own):
    before = read_run(own)
    own_barcode, unknown = BARCODE[1], 99
    stamp = CLOCK + 1.5
    odd = [(stamp, unknown, 1, 0), (stamp, own_barcode, 1, 0), (stamp, 72, -1, 0), (stamp, 72, 2, 0.5), (stamp, 72, 2, 0.5)]
    append(own / "Robot1_Measurement.dat", "".join("{} {} {} {}\n".format(*row) for row in odd))
    after = read_run(own)
    assert after.dropped == replace(before.dropped, unknown_barcodes=2, duplicates=1, impossible=1)
    assert len(after.logs[1].measurements) == len(before.logs[1].measurements) + 1
    assert (np.diff(after.logs[1].measurements[:, 0]) >= 0).all()


def test_lines_that_are_out_of_order_are_put_in_order(own):
    before = read_run(own)
    for name in ("Robot1_Measurement.dat", "Robot1_Odometry.dat", "Robot1_Groundtruth.dat"):
        lines = (own / name).read_text().splitlines(keepends=True)[4:]
        (own / name).write_text(HEAD + "".join(lines[len(lines) // 2 :] + lines[: len(lines) // 2]))
    np.testing.assert_array_equal(read_run(own).logs[1].commands, before.logs[1].commands)
    np.testing.assert_array_equal(read_run(own).logs[1].truth, before.logs[1].truth)
    assert sorted(map(tuple, read_run(own).logs[1].measurements)) == sorted(map(tuple, before.logs[1].measurements))


def test_a_run_without_truth_is_a_run(own):
    for path in own.glob("Robot*_Groundtruth.dat"):
        path.unlink()
    scenario = frames(read_run(own), (1, 2))
    assert initial_headings(scenario.initial).full.all()
    assert scenario.initial[0].polygon().area == pytest.approx(np.prod(np.diff(scenario.team.arena, axis=0)))
    assert all(np.isnan(frame.truth.positions).all() for frame in scenario.frames)


def test_frames_are_at_the_measurements_own_times_and_hold_all_of_them(run):
    bounds = Bounds()
    found = list(frames(run, (1, 2, 3)).frames)
    stamps = {
        round(time - bounds.measurement_delay, 6) for log in run.logs.values() for time in log.measurements[:, 0].tolist()
    }
    assert [frame.time for frame in found] == sorted(stamps)
    assert [frame.odometry.start for frame in found] == [0.0, *[frame.time for frame in found[:-1]]]
    assert all(frame.odometry.robot.tolist() == [0, 1, 2] for frame in found)
    assert sum(len(frame.measurements[0].robot) for frame in found) == sum(len(log.measurements) for log in run.logs.values())


def test_records_of_one_stamp_share_a_frame(own):
    stamp = CLOCK + 1.9
    for robot in (1, 2):
        append(own / f"Robot{robot}_Measurement.dat", f"{stamp} 72 1.5 0.5\n")
    (frame,) = [each for each in frames(read_run(own), (1, 2)).frames if each.time == pytest.approx(1.86)]
    assert frame.measurements[0].robot.tolist() == [0, 1]


def test_robots_are_numbered_in_the_order_given_and_the_landmarks_follow(run):
    scenario = frames(run, (3, 1))
    assert scenario.team.robots == 2
    np.testing.assert_array_equal(scenario.team.landmarks, list(LANDMARKS.values()))
    found = list(scenario.frames)
    targets = {int(target) for frame in found for target in frame.measurements[0].target}
    assert targets == {0, 1, 2, 3, 4, 5}
    at = np.array([frame.time for frame in found])
    np.testing.assert_array_equal(np.array([frame.truth.positions for frame in found]), truth_at(run, (3, 1), at).positions)


@pytest.mark.parametrize("robots", [(), (4,), (1, 1)])
def test_a_team_that_is_none_is_refused(run, robots):
    with pytest.raises(InvalidInput, match="different robots"):
        frames(run, robots)


def test_a_part_of_a_run_is_the_part_of_its_frames(run):
    whole, part = list(frames(run, (1, 2)).frames), list(frames(run, (1, 2), 2.0, 3.0).frames)
    assert [frame.time for frame in part] == [frame.time for frame in whole if 2.0 < frame.time <= 5.0]
    assert part[0].odometry.start == 2.0
    with pytest.raises(InvalidInput, match="measurements"):
        frames(run, (1, 2), 1e4)


def test_where_the_truth_has_a_gap_nobody_knows(own):
    lines = (own / "Robot1_Groundtruth.dat").read_text().splitlines(keepends=True)
    (own / "Robot1_Groundtruth.dat").write_text("".join([*lines[:30], *lines[40:70]]))
    run = read_run(own)
    stamps = run.logs[1].truth[:, 0]
    times = np.array([stamps[0], stamps[25] + 0.01, stamps[26], stamps[25], stamps[-1] + 0.01])
    assert np.isnan(truth_at(run, (1,), times).headings[:, 0]).tolist() == [False, True, False, False, True]


@pytest.mark.parametrize("seed", range(20))
def test_the_initial_sets_hold_the_truth_wherever_they_are_drawn(run, seed):
    known = Start(0.3, 20 * DEGREE)
    scenario = frames(run, (1, 2, 3), 1.0, known=known, generator=np.random.default_rng(seed))
    truth = truth_at(run, (1, 2, 3), np.array([1.0]))
    assert all(set_.polygon().contains(place) for set_, place in zip(scenario.initial, truth.positions[0], strict=True))
    assert initial_headings(scenario.initial).contains(truth.headings[0]).all()


def test_a_range_record_holds_both_intervals_of_which_the_larger_counts():
    bounds, r = Bounds(), np.concatenate([np.linspace(0, 8, 4001), [0.2 / 0.15, 0.2 * 0.85 / 0.15, 0.2 * 1.15 / 0.15]])
    absolute, relative = bounds.range_columns(r)
    record = Range(time=0.0, robot=0, target=np.ones(len(r), dtype=int), range=r, bound=absolute, relative_bound=relative)
    least, greatest = record.interval()
    low = np.minimum(r - bounds.range, r / (1 + bounds.relative_range))
    high = np.maximum(r + bounds.range, r / (1 - bounds.relative_range))
    assert (least <= np.maximum(low, 0) + 1e-12).all()
    assert (greatest >= high - 1e-12).all()
    assert (least >= np.maximum(low, 0) - 0.071).all()
    assert (greatest <= high + 1e-12).all()


@pytest.mark.parametrize("name", ["distance", "turn", "slip", "reach", "swing"])
def test_one_record_is_never_wider_than_a_chain_of_records(name):
    knots = getattr(Bounds(), name)
    a, b = np.random.default_rng(3).exponential(2.0, (2, 500))
    assert (bound_over(knots, a + b) <= bound_over(knots, a) + bound_over(knots, b) + 1e-12).all()
    assert (bound_over(knots, a + b) >= bound_over(knots, a)).all()
    for length, bound in knots:
        assert bound_over(knots, length) == pytest.approx(bound)


@pytest.mark.parametrize("seed", range(5))
def test_a_smoothed_error_only_drifts_and_is_never_farther_away_than_the_jitter(seed):
    """The lemma behind chained bounds, on an error that jitters and drifts as much as it may."""
    generator, chained = np.random.default_rng(seed), Bounds().chained()
    times = np.cumsum(generator.exponential(0.05, 600))
    apart = np.abs(times[:, None] - times)
    drift, jitter = bound_over(chained.turn, 1.0), chained.heading_jitter
    drifted = np.append(0.0, np.cumsum(drift * np.diff(times) * generator.choice([-1, 1], 599)))
    error = drifted + jitter * generator.choice([-1, 1], 600)
    assert (np.abs(error[:, None] - error) <= 2 * jitter + drift * apart + 1e-9).all()
    smoothed = (error[None, :] + drift * apart).min(axis=1) + jitter
    assert (np.abs(smoothed - error) <= jitter + 1e-9).all()
    assert (np.abs(smoothed[:, None] - smoothed) <= drift * apart + 1e-9).all()


@pytest.mark.parametrize("length", [0.2, 1.0, 3.0])
def test_chained_bounds_take_the_jitter_out_of_the_records(length):
    bounds, lengths = Bounds(), np.linspace(0.001, 20, 2000)
    chained = bounds.chained(length)
    for name, jitter in (("turn", 2 * chained.heading_jitter), ("distance", 0.02), ("slip", 0.02), ("reach", 0.02)):
        drift = bound_over(getattr(chained, name), lengths)
        assert (bound_over(getattr(bounds, name), lengths) <= jitter + drift + 1e-12).all()
        assert bound_over(getattr(chained, name), length) == pytest.approx(bound_over(getattr(bounds, name), length))


@pytest.mark.parametrize("knots", [(), ((0.0, 1.0),), ((1.0, 1.0), (2.0, 3.0)), ((1.0, 1.0), (2.0, 0.5)), ((np.nan, 1.0),)])
def test_knots_of_no_concave_function_are_refused(knots):
    with pytest.raises(InvalidInput, match="turn"):
        Bounds(turn=knots)


def test_the_motion_is_the_integral_of_the_commands(run):
    bounds = Bounds(reach=((1.0, 100.0),))
    motions, commands = Motions(run, (1,), bounds), run.logs[1].commands
    for start, time in ((0.0, 0.05), (0.1, 0.18), (0.3, 4.0), (1.234, 1.235), (2.0, 2.0), (7.0, 9.5)):
        clock = np.linspace(start, time, 20001) - bounds.command_lag
        last = np.searchsorted(commands[:, 0], clock, side="right") - 1
        speed, rate = (np.where(last >= 0, commands[last, column], 0.0) for column in (1, 2))
        step = (time - start) / 20000
        turns = np.append(0.0, np.cumsum(rate[:-1]) * step)
        motion = motions.motion(0, start, time)
        assert motion.distance[0] == pytest.approx(bounds.speed_scale * speed[:-1].sum() * step, abs=1e-3)
        assert motion.turn[0] == pytest.approx(turns[-1], abs=1e-3)
        half = (turns.max() - turns.min()) / 2 + motion.turn_bound[0]
        assert motion.direction[0] == pytest.approx((turns.max() + turns.min()) / 2, abs=1e-3)
        assert motion.direction_bound[0] == pytest.approx(min(half, 1.55), abs=1e-3)


def test_motions_of_parts_add_up(run):
    motions = Motions(run, (1, 2), Bounds(reach=((1.0, 100.0),)))
    generator = np.random.default_rng(0)
    a, b, c = np.sort(generator.uniform(0.0, 9.0, (3, 100)), axis=0)
    for robot in (0, 1):
        first, second, both = (motions.motion(robot, *times) for times in ((a, b), (b, c), (a, c)))
        np.testing.assert_allclose(first.turn + second.turn, both.turn, atol=1e-12)
        np.testing.assert_allclose(first.distance + second.distance, both.distance, atol=1e-12)
        assert (both.turn_bound <= first.turn_bound + second.turn_bound + 1e-12).all()


@pytest.mark.parametrize("length", [0.01, 0.1, 0.7, 3.0])
def test_a_robot_that_keeps_its_bounds_is_where_its_motion_says(run, length):
    motions = Motions(run, (1, 2, 3), Bounds())
    start = np.arange(0.0, 8.0 - length, 0.093)
    before, after = (truth_at(run, (1, 2, 3), times) for times in (start, start + length))
    team = frames(run, (1, 2, 3)).team
    for robot in range(3):
        moves = motions.motion(robot, start, start + length)
        turn = wrap(after.headings[:, robot] - before.headings[:, robot] - moves.turn)
        assert (np.abs(turn) <= moves.turn_bound).all()
        moved = after.positions[:, robot] - before.positions[:, robot]
        for k, odometry in enumerate(records(moves, start, length)):
            assert within(odometry, float(before.headings[k, robot]), moved[k], team)


def records(moves, start, length):
    for k in range(len(start)):
        columns = {name: column[k] for name, column in moves.odometry_columns().items()}
        yield Odometry(start=start[k], time=start[k] + length, robot=0, **columns)


def within(odometry, heading, moved, team):
    headings = AngularIntervals(np.full(team.robots, heading), np.zeros(team.robots))
    sets = displacements(odometry, headings, team, odometry.time - odometry.start)
    ways = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    normals = np.column_stack([np.cos(ways), np.sin(ways)])
    return (normals @ moved <= sets.support(np.zeros(32, dtype=int), normals) + 1e-9).all()


def test_a_robot_whose_commands_stop_may_be_anywhere_within_reach(run):
    cut = faulty_run(run, 4.0)
    motions, bounds = Motions(cut, (1,), Bounds()), Bounds()
    held, silent = motions.motion(0, 4.5, 5.5), motions.motion(0, 5.5, 6.5)
    assert held.turn_bound == pytest.approx(22 * DEGREE)
    assert silent.turn_bound[0] == pytest.approx(bound_over(bounds.swing, 1.0))
    assert silent.distance == 0
    assert silent.distance_bound[0] == pytest.approx(bound_over(bounds.reach, 1.0))
    assert silent.direction_bound > 1.5


def faulty_run(run, until):
    log = run.logs[1]
    return replace(run, logs={1: replace(log, commands=log.commands[log.commands[:, 0] < until])})


def test_a_robot_that_is_told_nothing_at_all_may_be_anywhere(run):
    motion = Motions(faulty_run(run, -1.0), (1,), Bounds()).motion(0, 1.0, 2.0)
    assert motion.turn_bound == pytest.approx(60 * DEGREE)


def test_a_robot_that_drives_backwards_may_have_gone_either_way(run):
    log = run.logs[1]
    backwards = replace(run, logs={1: replace(log, commands=log.commands * [1, -1, 1])})
    motion = Motions(backwards, (1,), Bounds()).motion(0, 0.5, 1.5)
    assert motion.distance < 0
    assert motion.direction_bound > 1.5


@pytest.mark.parametrize("fault", sorted(FAULTS.keys() - {"exchanged"}))
def test_a_fault_spoils_one_robots_log_and_nothing_else(folder, fault):
    tables = read_tables(folder)
    spoilt = faulty(tables, fault, 2)
    for robot in (1, 3):
        assert spoilt.logs[robot] is tables.logs[robot]
    np.testing.assert_array_equal(spoilt.logs[2].truth, tables.logs[2].truth)
    assert same(run_of(read_tables(folder)), run_of(tables))


def test_a_silent_robot_says_nothing_and_then_goes_on(folder):
    spoilt = run_of(FAULTS["silent"](read_tables(folder), 2, start=3.0, duration=2.0))
    for table in (spoilt.logs[2].commands, spoilt.logs[2].measurements):
        assert not ((table[:, 0] > 3.0) & (table[:, 0] < 5.0)).any()
        assert table[-1, 0] > 5.0


def test_a_knocked_camera_is_biased_from_then_on(folder):
    tables = read_tables(folder)
    before, after = run_of(tables), run_of(FAULTS["biased"](tables, 2, start=4.0, bias=0.3))
    turned = wrap(after.logs[2].measurements[:, 3] - before.logs[2].measurements[:, 3])
    np.testing.assert_allclose(turned, np.where(before.logs[2].measurements[:, 0] >= 4.0, 0.3, 0.0), atol=1e-12)


def test_swapped_barcodes_name_the_other_robot(folder):
    tables = read_tables(folder)
    before, after = run_of(tables), run_of(faulty(tables, "swapped", 2))
    swap = {2: 3, 3: 2}
    subjects = [swap.get(int(subject), int(subject)) for subject in before.logs[1].measurements[:, 1]]
    assert after.logs[1].measurements[:, 1].astype(int).tolist() == subjects
    assert after.dropped.unknown_barcodes == sum(int((before.logs[k].measurements[:, 1] == swap[k]).sum()) for k in (2, 3))


def test_a_log_that_was_written_twice_is_the_same_run(folder):
    tables = read_tables(folder)
    before, after = run_of(tables), run_of(faulty(tables, "duplicated", 2))
    assert same(before, after)
    assert after.dropped.duplicates == len(before.logs[2].commands) + len(before.logs[2].measurements)


def test_a_clock_that_is_late_makes_all_of_its_stamps_late(folder):
    tables = read_tables(folder)
    before, after = run_of(tables), run_of(FAULTS["shifted"](tables, 2, by=0.5))
    np.testing.assert_allclose(after.logs[2].commands[:, 0], before.logs[2].commands[:, 0] + 0.5, atol=1e-6)
    np.testing.assert_array_equal(after.logs[2].truth, before.logs[2].truth)


def test_unknown_faults_and_robots_are_refused(folder):
    for fault, robot in (("lazy", 1), ("silent", 9)):
        with pytest.raises(InvalidInput):
            faulty(read_tables(folder), fault, robot)


@needs_data
def test_the_declared_bounds_of_motion_hold_on_the_real_data():
    run = read_run(Path(REAL))
    robots = sorted(run.logs)
    motions = Motions(run, robots, Bounds())
    for length in (0.05, 0.3, 2.0, 20.0):
        start = np.arange(2.0, 800.0, 0.37)
        before, after = (truth_at(run, robots, times) for times in (start, start + length))
        for robot in range(len(robots)):
            turn = wrap(after.headings[:, robot] - before.headings[:, robot])
            moves = motions.motion(robot, start, start + length)
            known = np.isfinite(turn)
            broken = np.abs(wrap(turn - moves.turn)) > moves.turn_bound
            assert broken[known].mean() < 1e-3
