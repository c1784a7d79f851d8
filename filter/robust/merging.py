"""Merging the sightings of one time into a belief: landmarks, then team mates, then the consequences.

**Whose barcode it was.** A barcode names a team mate, but another one may wear it. So it is asked of every team mate whether it
can have been what was seen: whether some pose of the robot and some position of the other one, as far as both are known, are
in the sector. If the one that was named is the only one, the sighting is merged as one of it. If there are others, the robot
has seen one of them, whichever, and nothing is learned of any. If it cannot have been the one that was named, the sighting is
rejected. So robots that have exchanged their barcodes, at any time, do no harm, and sightings that agree by chance do not count
as agreement.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from filter.arrays import Array, Mask
from filter.guarantee import Guarantee
from filter.linear.sources import Source
from filter.poses.slices import AGREED, COUNT, EARLIER
from filter.robust.belief import Disagreement, Distrusted, Late, Rejected, Restarted, RobustBelief, RobustEvent, Turned
from filter.robust.cameras import Alignment, Offsets
from filter.robust.hypotheses import Cut, Hypotheses
from filter.robust.slices import Sighting, narrow, see_any, see_body, see_place, seen_from, stay_within
from filter.robust.trust import Suspicion, Trust
from filter.robust.votes import Poll, Rules
from filter.team import Team

CONTESTED, ON_TRIAL = "several votes on it are being rejected", "its late camera is on trial"  # why a guarantee is suspended


class Merging:
    """The work of one prediction or update; the belief it begins with stays as it is."""

    def __init__(self, before: RobustBelief, team: Team, rules: Rules, cells: int, anywhere: Array) -> None:
        """Begin. Where a robot can be that starts over is given by supports (COUNT,) [m]."""
        self._before, self._time, self._team, self._rules, self._anywhere = before, before.time, team, rules, anywhere
        self._bodies = team.robots + len(team.landmarks)
        self._poll = Poll(before.sets, before.votes, before.time, rules, cells)
        self._judged: list[tuple[int, int, bool]] = []
        self._events: list[RobustEvent] = []
        self._since, self._disputed = map(np.copy, (before.guarantee.suspended_since, before.disputed))

    def left(self) -> RobustBelief:
        """Return the new belief after a move, in which something agrees with every vote: slices outside the arena are gone.

        Where only slices are left that do without a vote, one of these is proved wrong, or odometry, and a new window begins.
        Where nothing is left, the robot starts over: a bound was broken before.
        """
        for robot, known in enumerate(self._before.sets):
            if not len(known):
                self._restart(robot, "as odometry says, it has left the arena")
            elif not (known.without == AGREED).any():
                self._disagree(robot, known, Source("odometry", self._time, robot))
                self._poll.renew(robot, known)
        return self._told(self._before)

    def merge(self, sightings: Sequence[Sighting]) -> None:
        """Close the votes that are over, and merge sightings, one after the other."""
        for robot in range(self._team.robots):
            self._poll.expire(robot)
        offsets = self._before.offsets
        for robot, target, sector in sightings:
            if robot == target:
                if not offsets.turned[robot]:  # else its slices are of the camera's heading: a compass says nothing of that
                    self._cast(robot, target, partial(narrow, sector))
            elif not offsets.late[robot] or offsets.on_trial[robot]:
                self._see(robot, target, sector)

    def _see(self, robot: int, target: int, sector: Array) -> None:
        """Merge a sighting as one of whatever it can have been; only judge it if a sensor of it is put aside."""
        aside, mate = self._before.trust.aside(robot, target), target < self._team.robots
        if mate:
            cut, others = partial(see_body, self._hull(target), sector), self._others(robot, target, sector)
        else:
            cut, others = partial(see_place, self._team.landmarks[target - self._team.robots], sector), []
        if not others:
            agrees = self._poll.agrees(robot, cut) if aside else self._believe(robot, target, sector, cut)
            self._judged.append((robot, target, not agrees))
        elif not self._poll.agrees(robot, cut):
            self._judged.append((robot, target, True))
            if not aside:
                self._reject(self._source(robot, target))
        elif not aside:
            bodies = [self._hull(body) for body in (target, *others)]
            self._cast(robot, target, partial(see_any, bodies, sector), whoever=True)

    def _hull(self, robot: int) -> Array:
        """Return (COUNT,) supports of where a robot is for others: anywhere if what is known of it is disputed [m]."""
        return self._poll.sets[robot].hull() if self._relied_on(robot) else self._anywhere

    def _relied_on(self, robot: int) -> bool:
        """Return whether others may rely on a robot's region: nothing was rejected or disagreed there for a window's length."""
        return bool(self._before.guarantee.in_force[robot] and self._time - self._disputed[robot] > self._rules.window)

    def _others(self, robot: int, target: int, sector: Array) -> list[int]:
        """Return the team mates, besides the one that a barcode names, that can have been seen in a sector."""
        seer, found = self._seer(robot, target), []
        place = seen_from(sector, seer.low, seer.high, seer.reach)
        for body in range(self._team.robots):
            hull = self._hull(body)
            apart = (place + np.roll(hull, COUNT // 2) < 0).any()  # a line is between them
            if body not in {robot, target} and not apart and len(seer.cut(partial(see_body, hull, sector))):
                found.append(body)
        return found

    def _seer(self, robot: int, target: int) -> Hypotheses:
        """Return the slices that a sighting is merged into: if it is right, what does without it does not matter."""
        seer = self._poll.sets[robot]
        return seer.select(seer.without != target)

    def _believe(self, robot: int, target: int, sector: Array, cut: Cut) -> bool:
        """Merge a sighting into the robot that took it, and into the team mate that it is of; return whether all agree."""
        verdict = self._cast(robot, target, cut)
        if verdict == "rejected" or target >= self._team.robots or not self._relied_on(robot):
            return verdict == "agreed"
        seer = self._seer(robot, target)
        place = seen_from(sector, seer.low, seer.high, seer.reach)
        return self._cast(target, self._bodies + robot, partial(stay_within, place)) == verdict == "agreed"

    def _cast(self, robot: int, column: int, cut: Cut, whoever: bool = False) -> str:
        """Cast a vote and note what came of it."""
        known, source = self._poll.sets[robot], self._source(robot, column)
        verdict = self._poll.cast(robot, column, cut, whoever)
        if verdict == "rejected":
            self._disputed[robot] = self._time
            self._reject(source)
        elif verdict == "contradicted":
            self._disagree(robot, known.select(known.without != column), source)
        return verdict

    def _disagree(self, robot: int, known: Hypotheses, last: Source) -> None:
        """Note that the votes without which others agree, or the last one, are proved wrong."""
        columns = [column for column in np.unique(known.without).tolist() if column not in {AGREED, EARLIER}]
        suspects = (*(self._source(robot, column) for column in columns), last)
        self._events.append(Disagreement(self._time, robot, suspects))
        self._disputed[robot] = self._time

    def _reject(self, source: Source) -> None:
        self._events.append(Rejected(source, (Source("region", source.time, source.robot), source)))

    def _source(self, robot: int, column: int) -> Source:
        return self._before.votes.source(self._time, robot, column)

    def ended(self, sightings: Sequence[Sighting], suspicion: Suspicion, alignment: Alignment) -> RobustBelief:
        """Return the new belief: sensors are judged by the sightings, and those that were lost or misled start over."""
        before = self._before
        seen = before.offsets.seen(sightings, self._team.landmarks, before.trust.identity, alignment)
        offsets = seen.checked(self._poll.sets, alignment).judged(self._time, alignment)
        trust = before.trust.judged(self._time, self._judged, suspicion)
        misled = self._put_aside(trust, "camera") | self._put_aside(trust, "identity")
        turned, late = self._changed(offsets, 0, Turned), self._changed(offsets, 1, Late) & offsets.late
        for robot in np.flatnonzero(late).tolist():
            misled |= self._misled("camera", "robot", robot, self._time) & ~late
        since, lost = self._poll.contested()
        earlier = before.guarantee.suspended_since
        begun = np.where(np.isfinite(since), np.minimum(earlier, since), np.inf)
        begun = np.where(offsets.on_trial, np.minimum(earlier, self._time), begun)
        begun = np.where(turned, np.minimum(begun, offsets.good_until[:, 0]), begun)
        self._since = np.where(late, np.minimum(begun, offsets.good_until[:, 1]), begun)
        reasons = {
            "it is lost": lost,
            "it was misled": misled,
            "its camera is suspected to be turned": turned & offsets.turned,
            "its camera is trusted again": turned,
            "its camera is suspected to be late": late,
            "there is an estimate of its late camera again": before.offsets.on_trial & offsets.late & offsets.running,
        }
        for robot in range(self._team.robots):
            because = next((why for why, who in reasons.items() if who[robot]), "")
            if because:
                self._restart(robot, because)
        return self._told(replace(before, trust=trust, offsets=offsets))

    def _told(self, belief: RobustBelief) -> RobustBelief:
        """Return a belief with the sets, the votes and the events as they are now."""
        after = replace(belief, sets=tuple(self._poll.sets), votes=self._poll.votes, events=tuple(self._events))
        reasons = np.where(np.isinf(self._since), "", np.where(belief.offsets.on_trial, ON_TRIAL, CONTESTED)).tolist()
        return replace(after, guarantee=Guarantee(self._since, tuple(reasons)), disputed=self._disputed)

    def _changed(self, now: Offsets, column: int, event: type[Turned] | type[Late]) -> Mask:
        """Note which cameras are suspected to be turned, 0, or late, 1, or no longer; return (n,) of which that is new."""
        before, after = self._before.offsets.suspected[:, column], now.suspected[:, column]
        found = np.column_stack([now.mean[:, 3 + column], now.deviations[:, column], now.good_until[:, column]])
        for robot in np.flatnonzero(before != after).tolist():
            self._events.append(event(self._time, robot, bool(after[robot]), *found[robot].tolist()))
        return before != after

    def _put_aside(self, trust: Trust, sensor: str) -> Mask:
        """Note which cameras or identities are put aside or trusted again; return (n,) who has believed one put aside."""
        before, after = getattr(self._before.trust, sensor), getattr(trust, sensor)
        misled = np.zeros(self._team.robots, dtype=bool)
        for body in np.flatnonzero(before != after).tolist():
            kind, (since, pairs) = ("robot" if body < self._team.robots else "landmark"), trust.charges(sensor, body)
            self._events.append(Distrusted(self._time, sensor, kind, body, bool(after[body]), since, pairs))
            if after[body]:
                misled |= self._misled(sensor, kind, body, since)
        return misled

    def _misled(self, sensor: str, kind: str, body: int, since: float) -> Mask:
        """Return (n,) who has believed a sensor lately; a team mate that was proved to be itself misled nobody until then."""
        recent = since if (sensor, kind) == ("identity", "robot") else self._time - self._rules.window
        return self._poll.believed(sensor, body, self._bodies, recent)

    def _restart(self, robot: int, because: str) -> None:
        self._events.append(Restarted(self._time, robot, min(float(self._since[robot]), self._time), because))
        self._poll.restart(robot, Hypotheses.agreed(self._anywhere))
        self._since[robot], self._disputed[robot] = np.inf, self._time
