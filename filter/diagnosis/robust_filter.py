"""The filter with evidence on cameras beside its proofs: one that is turned or late is said to be, and no longer heard."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from filter.arrays import checked, instance
from filter.cameras.alignment import Alignment
from filter.cameras.offsets import Offsets
from filter.cameras.sightings import Sightings
from filter.diagnosis.set_membership_filter import Policy, SetMembershipFilter
from filter.diagnosis.starting_over import suspended, waiting
from filter.diagnosis.told import Records, some, without_all
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.projection.stop import never
from filter.records.frame import Frame
from filter.records.measurements import Bearing, Measurement, Range
from filter.records.odometry import Odometry
from filter.records.presence import Change
from filter.records.relative import RelativeHeading
from filter.sets.belief import Belief, Diagnosis, Event
from filter.sets.suspect import Late, StartsOver, Turned


@dataclass(frozen=True, eq=False)
class RobustFilter(SetMembershipFilter):
    """A `SetMembershipFilter` that suspects cameras, too, that are turned or late for good, as robots drive: by evidence.

    The bearings of a turned camera can all agree, on another heading, so that nothing proves it. What is suspected is told
    (`Turned`, `Late`), and its robot starts over, its guarantee suspended since the camera looked good last. From then on
    of a turned camera ranges alone are merged, of a late one nothing, until it agrees again. So nothing of an estimate ever
    enters a region. In the time of a doubt the estimates go on, but nobody is suspected, or trusted again, until it is over;
    who is acquitted by evidence, as all agrees, need not have driven far if its camera is known not to be turned.

    Of a suspected camera there may be no estimate any more. If the guarantee is suspended, it is heard then until there is
    one, and its robot starts over once more. Mates that have believed a camera before it was suspected do not start over.
    The policy "raise" is about conflicts only: a suspicion raises nothing. A belief of a filter without evidence is taken as
    one in which no camera is suspected.

    Attributes:
        alignment: When a camera is suspected to be turned or late. Sensors that are not at a robot's centre are not.
    """

    policy: Policy = "reject"
    alignment: Alignment = field(default_factory=Alignment, metadata=checked(instance, "alignment", Alignment))

    def start(self, time: float, positions: Sequence[Polygon | None], headings: AngularIntervals | None = None) -> Belief:
        """Return the belief before any measurement; `InvalidInput` also if a polygon is wholly outside the arena."""
        belief = super().start(time, positions, headings)
        return replace(belief, cameras=self._cameras(belief))

    def predict(self, belief: Belief, time: float, odometry: Odometry | None = None) -> Belief:
        """Return the belief at a later time [s], as the filter without evidence does."""
        later, there = super().predict(belief, time, odometry), belief.guarantee.of_those_there(odometry)
        cameras = self._cameras(belief).moved(there, self.team, later.time - belief.time, self.alignment)
        return replace(later, cameras=cameras)

    def update(self, belief: Belief, measurements: Sequence[Measurement] = ()) -> Belief:
        """Return the belief after measurements taken at its time, without those of suspected cameras."""
        self.team.check_belief(belief, Belief, "headings")
        records = self.team.checked(belief.time, measurements, belief.guarantee.away)
        known, events = self._suspecting(belief, self._seen(belief, records))
        found = super().update(known, heard(records, self._cameras(known)))
        return replace(found, cameras=known.cameras, events=events + found.events)

    def placed(self, belief: Belief, robot: int, polygon: Polygon | None, heading: AngularIntervals | None = None) -> Belief:
        """Return the belief in which a robot is somewhere now; what is suspected of its camera stays."""
        return replace(super().placed(belief, robot, polygon, heading), cameras=self._cameras(belief).without(robot))

    def changed(self, belief: Belief, change: Change) -> Belief:
        """Return the belief in which a robot is `placed`, or in which one has left."""
        return replace(super().changed(belief, change), cameras=self._cameras(belief).without(change.robot))

    def _together(self, belief: Belief, frames: Sequence[Frame]) -> Belief | None:  # noqa: ARG002 - whatever they are
        """Return None: estimates need a step for each instant."""
        return None

    def _cameras(self, belief: Belief) -> Offsets:
        return belief.cameras or Offsets.none(self.team.robots, belief.time)

    def _seen(self, belief: Belief, records: Records) -> Offsets:
        """Return what is estimated with records, but for landmarks that are not what they are taken for."""
        others = (suspect for suspect in belief.aside if suspect.kind in ("body", "sighting"))
        sightings, box = Sightings.of(without_all(others, records), self.team.robots), belief.polytope
        seen = self._cameras(belief).seen(sightings, self.team.landmarks, self.alignment)
        return seen.checked(box.lower, box.upper, belief.headings, self.alignment).judged(belief.time, self.alignment)

    def _suspecting(self, belief: Belief, now: Offsets) -> tuple[Belief, tuple[Event, ...]]:
        """Return the belief in which robots whose cameras are newly suspected start over, and what is to be told."""
        before, events = self._cameras(belief), list[Event]()
        if belief.diagnosis and belief.diagnosis.hypotheses:
            return replace(belief, cameras=replace(now, suspected=before.suspected)), ()
        events += [*_changes(belief.time, before, now, 0, Turned), *_changes(belief.time, before, now, 1, Late)]
        lost = (now.suspected & ~before.suspected).any(axis=1) | (now.on_trial & now.running)
        since = np.where(now.suspected, now.good_until, belief.time).min(axis=1)
        if lost.any():
            robots = dict(zip(np.flatnonzero(lost).tolist(), since[lost].tolist(), strict=True))
            over = StartsOver(belief.time, tuple(robots), conflict=())
            belief = suspended(self._strict(never), belief, robots, over.because(str))
            events.append(over)
        return self._on_trial(belief, now), tuple(events)

    def _on_trial(self, belief: Belief, now: Offsets) -> Belief:
        """Return the belief with those on trial that are heard from now on; what they say puts nothing in force again."""
        diagnosis = belief.diagnosis or Diagnosis()
        cameras = now.waiting(np.isin(np.arange(self.team.robots), list(waiting(diagnosis))))
        robots = set(np.flatnonzero(cameras.on_trial).tolist())
        trials = tuple(replace(trial, used={}) if trial.suspect.robot in robots else trial for trial in diagnosis.suspended)
        return replace(belief, cameras=cameras, diagnosis=replace(diagnosis, suspended=trials))


def _changes(time: float, before: Offsets, now: Offsets, column: int, event: type[Turned] | type[Late]) -> list[Event]:
    """Return which cameras are suspected since now [s] to be turned, column 0, or late, 1, or no longer."""
    robots = np.flatnonzero(before.suspected[:, column] != now.suspected[:, column])
    found = now.mean[robots, 3 + column], now.deviations[robots, column], now.good_until[robots, column]
    told = zip(robots.tolist(), now.suspected[robots, column].tolist(), *(each.tolist() for each in found), strict=True)
    return [event(time, *each) for each in told]


def heard(records: Records, cameras: Offsets) -> Records:
    """Return what is left of records without the angles of cameras that are turned, and all that late ones say."""
    late, turned = cameras.late & ~cameras.on_trial, cameras.turned & ~cameras.on_trial
    unheard = {Bearing: turned | late, RelativeHeading: turned | late, Range: late}
    left = (some(each, ~unheard[type(each)][each.robot]) if type(each) in unheard else each for each in records)
    return tuple(record for record in left if record is not None)
