"""Merging the sightings of one time into a belief: landmarks, then team mates, then the consequences.

**Whose barcode it was.** A barcode names a team mate, but another one may wear it. So it is asked of every team mate whether it
can have been what was seen: whether some pose of the robot and some position of the other one, as far as both are known, are
in the sector. If the one that was named is the only one, the sighting is merged as one of it. If there are others, the robot
has seen one of them, whichever, and nothing is learned of any. If it cannot have been the one that was named, the sighting is
rejected. So robots that have exchanged their barcodes, at any time, do no harm, and sightings that agree by chance do not count
as agreement.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from filter.arrays import Array, Mask
from filter.linear.sources import Source
from filter.robust.belief import Disagreement, Distrusted, Late, Restarted, RobustBelief, RobustEvent, Turned
from filter.robust.camera_filter import Estimating
from filter.robust.cameras import Alignment, Offsets
from filter.robust.cuts import narrowed, seeing_any, seeing_body, seeing_place, within
from filter.robust.hypotheses import Cut, Hypotheses
from filter.robust.sightings import Sightings
from filter.robust.slices import COUNT, seen_from
from filter.robust.trust import Suspicion, Trust
from filter.robust.votes import Poll, Rules
from filter.sets.events import Rejected
from filter.team import Team


class Merging:
    """The work of one update; the belief it begins with stays as it is."""

    def __init__(self, before: RobustBelief, team: Team, rules: Rules, cells: int, anywhere: Array) -> None:
        """Begin: votes that are over are closed. Where a robot can be that starts over is given by supports (COUNT,) [m]."""
        self._before, self._team, self._rules, self._anywhere = before, team, rules, anywhere
        self._bodies = team.robots + len(team.landmarks)
        self._poll = Poll(before.sets, before.votes, before.time, rules, cells)
        self._judged: list[tuple[int, int, bool]] = []
        self._events: list[RobustEvent] = []
        self._disputed = before.disputed.copy()
        for robot in range(team.robots):
            self._poll.expire(robot)

    def merge(self, sightings: Sightings) -> None:
        """Merge sightings, one after the other."""
        for robot, target, sector in zip(sightings.robot.tolist(), sightings.target.tolist(), sightings.sector, strict=True):
            if robot == target:
                if self._before.offsets.turned[robot]:
                    continue  # its slices are of the camera's heading, of which a compass says nothing
                self._cast(robot, target, partial(narrowed, sector))
            elif self._before.offsets.late[robot] and not self._before.offsets.on_trial[robot]:
                continue
            elif target >= self._team.robots:
                self._landmark(robot, target, sector)
            else:
                self._team_mate(robot, target, sector)

    def _landmark(self, robot: int, target: int, sector: Array) -> None:
        """Merge a sighting of a landmark; only judge it if a sensor of it is put aside."""
        cut = partial(seeing_place, self._team.landmarks[target - self._team.robots], sector)
        aside = self._before.trust.aside(robot, target)
        agrees = self._poll.agrees(robot, cut) if aside else self._cast(robot, target, cut) == "agreed"
        self._judged.append((robot, target, not agrees))

    def _team_mate(self, robot: int, target: int, sector: Array) -> None:
        """Merge a sighting of a team mate as one of whoever it can have been; only judge it if a sensor of it is put aside."""
        cut, others = partial(seeing_body, self._hull(target), sector), self._others(robot, target, sector)
        aside = self._before.trust.aside(robot, target)
        if not others:
            agrees = self._poll.agrees(robot, cut) if aside else self._both(robot, target, sector, cut)
            self._judged.append((robot, target, not agrees))
        elif not self._poll.agrees(robot, cut):
            self._judged.append((robot, target, True))
            if not aside:
                self._reject(self._source(robot, target))
        elif not aside:
            bodies = [self._hull(body) for body in (target, *others)]
            self._cast(robot, target, partial(seeing_any, bodies, sector), whoever=True)

    def _hull(self, robot: int) -> Array:
        """Return (COUNT,) supports of where a robot is for others: anywhere if what is known of it is disputed [m]."""
        return self._poll.sets[robot].hull() if self._relied_on(robot) else self._anywhere

    def _relied_on(self, robot: int) -> bool:
        """Return whether others may rely on a robot's region: nothing was rejected or disagreed there for a window's length."""
        return bool(self._before.in_force[robot] and self._before.time - self._disputed[robot] > self._rules.window)

    def _others(self, robot: int, target: int, sector: Array) -> list[int]:
        """Return the team mates, besides the one that a barcode names, that can have been seen in a sector."""
        seer = self._seer(robot, target)
        place, found = seen_from(seer.low, seer.high, seer.reach, sector), []
        for body in range(self._team.robots):
            hull = self._hull(body)
            apart = (place + np.roll(hull, COUNT // 2) < 0).any()  # a line is between them
            if body not in {robot, target} and not apart and len(seer.cut(partial(seeing_body, hull, sector))):
                found.append(body)
        return found

    def _seer(self, robot: int, target: int) -> Hypotheses:
        """Return the slices that a sighting is merged into: if it is right, what does without it does not matter."""
        seer = self._poll.sets[robot]
        return seer.select(seer.without != target)

    def _both(self, robot: int, target: int, sector: Array, cut: Cut) -> bool:
        """Merge a sighting into the robot that took it and into the team mate that it is of; return whether both agree."""
        verdict = self._cast(robot, target, cut)
        if verdict == "rejected" or not self._relied_on(robot):
            return verdict == "agreed"
        seer = self._seer(robot, target)
        place = seen_from(seer.low, seer.high, seer.reach, sector)
        return self._cast(target, self._bodies + robot, partial(within, place)) == verdict == "agreed"

    def _cast(self, robot: int, column: int, cut: Cut, whoever: bool = False) -> str:
        """Cast a vote and note what came of it."""
        others = np.unique(self._poll.sets[robot].without)
        verdict, source = self._poll.cast(robot, column, cut, whoever), self._source(robot, column)
        if verdict != "agreed":
            self._disputed[robot] = self._before.time
        if verdict == "rejected":
            self._reject(source)
        elif verdict == "contradicted":
            suspects = [self._source(robot, other) for other in others.tolist() if other not in (-1, -2, column)]
            self._events.append(Disagreement(self._before.time, robot, (*suspects, source)))
        return verdict

    def _reject(self, source: Source) -> None:
        self._events.append(Rejected(source, (Source("region", source.time, source.robot), source)))

    def _source(self, robot: int, column: int) -> Source:
        return self._before.votes.source(self._before.time, robot, column)

    def ended(self, sightings: Sightings, suspicion: Suspicion, alignment: Alignment) -> RobustBelief:
        """Return the new belief: sensors are judged by the sightings, and those that were lost or misled start over."""
        before, offsets = self._before, self._estimated(sightings, alignment)
        trust = before.trust.judged(before.time, self._judged, suspicion)
        misled = self._put_aside(trust, "camera") | self._put_aside(trust, "identity")
        turned, late = self._changed(offsets, 0, Turned), self._changed(offsets, 1, Late) & offsets.late
        for robot in np.flatnonzero(late).tolist():
            misled |= self._misled("camera", "robot", robot, before.time) & ~late
        doubtful = np.array([self._doubtful_since(robot) for robot in range(self._team.robots)])
        doubtful = np.where(offsets.on_trial, np.minimum(before.doubtful_since, before.time), doubtful)
        doubtful = np.where(turned, np.minimum(doubtful, offsets.good_until[:, 0]), doubtful)
        doubtful = np.where(late, np.minimum(doubtful, offsets.good_until[:, 1]), doubtful)
        suspended = np.where(np.isfinite(doubtful), before.time, before.suspended)
        reasons = {
            "it was misled": misled,
            "its camera is suspected to be turned": turned & offsets.turned,
            "its camera is trusted again": turned,
            "its camera is suspected to be late": late,
            "there is an estimate of its late camera again": before.offsets.on_trial & offsets.late & offsets.running,
        }
        for robot in range(self._team.robots):
            because = "it is lost" if self._poll.lost(robot) else next((why for why in reasons if reasons[why][robot]), "")
            if because:
                self._restart(robot, min(float(doubtful[robot]), before.time), because)
                doubtful[robot], suspended[robot] = np.inf, before.time
        sets, votes, times = tuple(self._poll.sets), self._poll.votes, (doubtful, suspended, self._disputed)
        return RobustBelief(before.time, sets, votes, trust, offsets, *times, tuple(self._events))

    def _estimated(self, sightings: Sightings, alignment: Alignment) -> Offsets:
        """Return what is known of the cameras after sightings of landmarks."""
        estimating = Estimating(self._before.offsets, alignment)
        estimating.see(sightings, self._team.robots, self._team.landmarks, self._before.trust.identity)
        estimating.check(self._poll.sets)
        estimating.judge(self._before.time)
        return estimating.offsets

    def _doubtful_since(self, robot: int) -> float:
        """Return since when several votes on a robot are being rejected [s]; infinite if they are not."""
        if self._poll.recent(robot)[1].sum() < 2:
            return np.inf
        return min(float(self._before.doubtful_since[robot]), self._poll.first_rejected(robot))

    def _changed(self, now: Offsets, column: int, event: type[Turned] | type[Late]) -> Mask:
        """Note which cameras are suspected to be turned, 0, or late, 1, or no longer; return (n,) of which that is new."""
        before, after = self._before.offsets.suspected[:, column], now.suspected[:, column]
        found = np.column_stack([now.mean[:, 3 + column], now.deviations[:, column], now.good_until[:, column]])
        for robot in np.flatnonzero(before != after).tolist():
            self._events.append(event(self._before.time, robot, bool(after[robot]), *found[robot].tolist()))
        return before != after

    def _put_aside(self, trust: Trust, sensor: str) -> Mask:
        """Note which cameras or identities are put aside or trusted again; return (n,) who has believed one put aside."""
        before, after = getattr(self._before.trust, sensor), getattr(trust, sensor)
        misled = np.zeros(self._team.robots, dtype=bool)
        for body in np.flatnonzero(before != after).tolist():
            kind, (since, pairs) = ("robot" if body < self._team.robots else "landmark"), trust.charges(sensor, body)
            self._events.append(Distrusted(self._before.time, sensor, kind, body, bool(after[body]), since, pairs))
            if after[body]:
                misled |= self._misled(sensor, kind, body, since)
        return misled

    def _misled(self, sensor: str, kind: str, body: int, since: float) -> Mask:
        """Return (n,) who has believed a sensor lately; a team mate that was proved to be itself misled nobody until then."""
        recent = since if (sensor, kind) == ("identity", "robot") else self._before.time - self._rules.window
        return self._poll.believed(sensor, body, self._bodies, recent)

    def _restart(self, robot: int, since: float, because: str) -> None:
        self._poll.restart(robot, Hypotheses.agreed(self._anywhere))
        self._disputed[robot] = self._before.time
        self._events.append(Restarted(self._before.time, robot, since, because))
