"""The last instants, tried again: many suspects at once, and yet the same as one by one."""

from itertools import cycle

import numpy as np
import pytest
from helpers.drawn.broken import drawn, going_on, stepped
from helpers.teams import snapshot

from experiments.broken.fault import KINDS
from filter import Bearing, Compass, Odometry, Polygon, Range, Suspect, Team
from filter.diagnosis import judging, replays
from filter.diagnosis.replays import tried_again


def told(records):
    """Return kinds, robots and targets of single readings, each once."""
    return {
        (type(record).__name__, *pair)
        for record in records
        for pair in zip(
            record.robot.tolist(), getattr(record, "target", np.full(len(record.robot), None)).tolist(), strict=True
        )
    }


def of_the_doubt(kind, landmarks, monkeypatch):
    """Return what is asked when a doubt begins, with an entry for each time that instants were tried again for the answer."""
    asked, times = [], []
    once = replays._replayed
    monkeypatch.setattr(replays, "_replayed", lambda *given: times.append(0) or once(*given))
    monkeypatch.setattr(judging, "tried_again", lambda *given: asked.append(given) or tried_again(*given))
    episode = drawn(kind, 4, landmarks)
    filter_ = going_on(episode.team)
    belief = filter_.start(0.0, episode.positions, episode.headings)
    for frame in episode.frames:
        belief = stepped(filter_, belief, frame)
        if asked:
            break
    return asked[0], times


def living(found):
    """Return the hypotheses that can be; of each suspect that was tried alone it is told what came of that."""
    assert all((each is None) == bool(tried.end) and (each is None or each.suspects == tried.suspects) for each, tried in found)
    return [each for each, _ in found if each is not None]


@pytest.mark.parametrize(("kind", "landmarks"), list(zip(KINDS, cycle([4, 2]), strict=False)))
def test_many_at_once_are_excluded_as_one_by_one(kind, landmarks, monkeypatch):
    (strict, recent, suspects, alone), times = of_the_doubt(kind, landmarks, monkeypatch)
    count = len(times)
    times.clear()
    apart = living(tried_again(strict, recent, suspects, suspects))
    assert count <= len(times)
    for some in (alone, ()):  # whoever is named is in most conflicts: of nobody, so that these are among the many
        together = living(tried_again(strict, recent, suspects, some))
        assert [each.suspects for each in together] == [each.suspects for each in apart]
        for one, other in zip(together, apart, strict=True):
            assert snapshot(one.belief.polytope) == snapshot(other.belief.polytope)
            assert one.used == other.used


def test_a_sighting_is_implied_by_its_sensor_and_its_body():
    sighting = Suspect("sighting", 0, 4)
    assert replays._is_implied(sighting, {("body", -1, 4)})
    assert replays._is_implied(sighting, {("sensor", 0, -1)})
    assert not replays._is_implied(sighting, {("sensor", 1, -1), ("body", -1, 3), ("past", 0, -1)})
    assert not replays._is_implied(Suspect("body", None, 4), {("sensor", 0, -1)})


def test_nothing_is_left_that_was_read_of_those_who_are_exchanged_nor_of_any_of_many():
    records = (Bearing(0.0, [0, 0, 0, 3, 3], [1, 2, 4, 1, 5], 0.1, 0.1), Compass(0.0, [0, 3], 0.1, 0.1))
    left = replays._without_them([Suspect("exchange", 1, 2)], records)
    assert told(left) == {("Bearing", 0, 4), ("Bearing", 3, 5), ("Compass", 0, None), ("Compass", 3, None)}
    left = replays._without_them(
        [Suspect("exchange", 1, 2), Suspect("past", 0), Suspect("sensor", 3), Suspect("compass", 3)], records
    )
    assert told(left) == {("Bearing", 0, 4), ("Compass", 0, None)}


def test_where_there_is_no_arena_many_robots_in_doubt_are_not_farther_away_than_can_be_counted():
    count, team = 6, Team(7, [[4.0, 4.0], [-4.0, 4.0]], speed_limit=1.0, turn_rate_limit=1.0)
    filter_ = going_on(team, cells=0)
    places = 2.0 * np.stack([np.cos(np.arange(7.0)), np.sin(np.arange(7.0))], axis=1)
    belief = filter_.start(0.0, [Polygon.box(place - 0.1, place + 0.1) for place in places])
    robot, target = np.nonzero(~np.eye(7, dtype=bool))
    apart = np.hypot(*(places[robot] - places[target]).T)
    for step in range(count):
        apart[0] += 9.0 * (step == count - 1)
        told = Odometry(float(step), step + 1.0, range(7), 0.0, 0.01, 0.0, 0.01, direction_bound=0.01, slip_bound=0.0)
        belief = filter_.update(filter_.predict(belief, step + 1.0, told), [Range(step + 1.0, robot, target, apart, 0.1, 0.0)])
    assert belief.suspects
    assert belief.regions.contains(places).all()
