"""The last instants, tried again: many suspects at once, and yet the same as one by one."""

import pytest
from helpers.drawn.broken import drawn, going_on, stepped
from helpers.teams import snapshot

from experiments.broken.fault import KINDS
from filter import Suspect
from filter.diagnosis import judging, replays
from filter.diagnosis.replays import tried_again


def slowly(strict, recent, suspects, named):
    """Return the same, with each suspect alone."""
    return tried_again(strict, recent, suspects, suspects)


def of_the_doubt(kind, landmarks, monkeypatch):
    """Return what is asked when a doubt begins, and how often instants were tried again for the answer."""
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
            return asked[0], times
    return None


@pytest.mark.parametrize("landmarks", [4, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_many_at_once_are_excluded_as_one_by_one(kind, landmarks, monkeypatch):
    found = of_the_doubt(kind, landmarks, monkeypatch)
    if found is None:
        pytest.skip("nothing was found to be wrong")
    given, times = found
    together = tried_again(*given)
    count = len(times) // 2
    times.clear()
    apart = slowly(*given)
    assert count <= len(times)
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
