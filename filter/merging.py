"""Merging the sightings of one time into a belief: landmarks, then team mates, then the consequences."""

from __future__ import annotations

from functools import partial

import numpy as np

from filter.arrays import Array, Mask
from filter.belief import Rejected, Source
from filter.hypotheses import Cut, Hypotheses
from filter.robust_belief import Disagreement, Distrusted, Restarted, RobustBelief, RobustEvent
from filter.sightings import Sightings
from filter.slices import narrow, see_body, see_place, seen_from, stay_within
from filter.team import Team
from filter.trust import Suspicion
from filter.voting import Poll, Rules


class Merging:
    """The work of one update; the belief it begins with stays as it is."""

    def __init__(self, before: RobustBelief, team: Team, rules: Rules, suspicion: Suspicion, cells: int) -> None:
        """Begin: votes that are over are closed."""
        self._before, self._team, self._rules, self._suspicion = before, team, rules, suspicion
        self._bodies = team.robots + len(team.landmarks)
        self._poll = Poll(before.sets, before.votes, before.time, rules, cells)
        self._judged: list[tuple[int, int, bool]] = []
        self._events: list[RobustEvent] = []
        for robot in range(team.robots):
            self._poll.expire(robot)

    def merge(self, sightings: Sightings) -> None:
        """Merge sightings, one after the other."""
        for robot, target, sector in zip(sightings.robot.tolist(), sightings.target.tolist(), sightings.sector, strict=True):
            cut = self._cut(robot, target, sector)
            if robot == target:
                self._cast(robot, target, cut)
            elif self._before.trust.aside(robot, target):
                self._judged.append((robot, target, not self._poll.agrees(robot, cut)))
            else:
                self._judged.append((robot, target, not self._both(robot, target, sector, cut)))

    def _cut(self, robot: int, target: int, sector: Array) -> Cut:
        """Return what a sighting does to the slices of the robot that took it."""
        if robot == target:
            return partial(_narrowed, sector)
        if target >= self._team.robots:
            return partial(_seeing_place, self._team.landmarks[target - self._team.robots], sector)
        return partial(_seeing_body, self._poll.sets[target].hull(), sector)

    def _both(self, robot: int, target: int, sector: Array, cut: Cut) -> bool:
        """Merge a sighting into the robot that took it and into the team mate that it is of; return whether both agree."""
        verdict = self._cast(robot, target, cut)
        if verdict == "rejected" or target >= self._team.robots:
            return verdict == "agreed"
        seer = self._poll.sets[robot]
        seer = seer.select(seer.without != target)  # if the sighting is right, what does without it does not matter
        place = seen_from(seer.low, seer.high, seer.reach, sector)
        return self._cast(target, self._bodies + robot, partial(_within, place)) == verdict == "agreed"

    def _cast(self, robot: int, column: int, cut: Cut) -> str:
        """Cast a vote and note what came of it."""
        others = np.unique(self._poll.sets[robot].without)
        verdict, source = self._poll.cast(robot, column, cut), self._source(robot, column)
        if verdict == "rejected":
            self._events.append(Rejected(source, (Source("region", self._before.time, robot), source)))
        elif verdict == "contradicted":
            suspects = [self._source(robot, other) for other in others.tolist() if other not in (-1, -2, column)]
            self._events.append(Disagreement(self._before.time, robot, (*suspects, source)))
        return verdict

    def _source(self, robot: int, column: int) -> Source:
        time = self._before.time
        if column >= self._bodies:
            return Source("sighting", time, column - self._bodies, robot)
        return Source("compass", time, robot) if column == robot else Source("sighting", time, robot, column)

    def ended(self, anywhere: Array) -> RobustBelief:
        """Return the new belief: sensors are judged, and who is lost or had believed a guilty one starts over.

        Args:
            anywhere: (COUNT,) supports of where a robot that starts over can be [m].
        """
        before, time = self._before, self._before.time
        trust = before.trust.judged(time, self._judged, self._suspicion)
        doubtful, suspended = before.doubtful_since.copy(), before.suspended.copy()
        misled = self._put_aside(before.trust.camera, trust.camera, "camera") | self._put_aside(
            before.trust.identity, trust.identity, "identity"
        )
        for robot in range(self._team.robots):
            rejected = self._poll.recent(robot)[1]
            lost = self._poll.lost(robot)
            doubtful[robot] = min(doubtful[robot], self._poll.first_rejected(robot)) if rejected.sum() > 1 else np.inf
            if lost or misled[robot]:
                self._restart(robot, anywhere, float(min(doubtful[robot], time)), "it is lost" if lost else "it was misled")
                doubtful[robot] = np.inf
                suspended[robot] = time
            elif np.isfinite(doubtful[robot]):
                suspended[robot] = time
        sets, votes = tuple(self._poll.sets), self._poll.votes
        return RobustBelief(time, sets, votes, trust, doubtful, suspended, tuple(self._events))

    def _put_aside(self, before: Mask, after: Mask, sensor: str) -> Mask:
        """Note which cameras or identities are put aside or trusted again; return (n,) who has believed one put aside."""
        misled = np.zeros(self._team.robots, dtype=bool)
        for body in np.flatnonzero(before != after).tolist():
            self._events.append(Distrusted(self._before.time, sensor, body, bool(after[body])))
            if after[body]:
                misled |= self._poll.believed(sensor, body, self._bodies)
        return misled

    def _restart(self, robot: int, anywhere: Array, since: float, because: str) -> None:
        self._poll.restart(robot, Hypotheses.agreed(anywhere))
        self._events.append(Restarted(self._before.time, robot, since, because))


def _narrowed(sector: Array, low: Array, high: Array, _: Array) -> Mask:
    return narrow(low, high, sector[0], sector[1])


def _seeing_place(place: Array, sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    return see_place(low, high, reach, place, sector)


def _seeing_body(body: Array, sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    return see_body(low, high, reach, body, sector)


def _within(place: Array, _low: Array, _high: Array, reach: Array) -> Mask:
    return stay_within(reach, place)
