"""The set-membership filter: the strict one, that can go on after a conflict, with all that can be the case."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from filter.arrays import Integers, checked, instance, shown
from filter.diagnosis import judging, quiet
from filter.diagnosis.cover import cover_of
from filter.diagnosis.hypotheses import Strict
from filter.diagnosis.starting_over import assumption
from filter.diagnosis.told import without_all
from filter.diagnosis.tolerant import TolerantFilter
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.around import hulls_of
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.projection.stop import IsOver, never
from filter.records.frame import Frame
from filter.records.measurements import Measurement
from filter.records.odometry import Odometry
from filter.records.presence import Change
from filter.sets.belief import Belief, Diagnosis
from filter.sets.conflict import anywhere

Policy = Literal["raise", "reject"]


@dataclass(frozen=True, eq=False)
class SetMembershipFilter(TolerantFilter):
    """A `Filter`: keeps a belief about a moving team that contains the truth as long as every declared bound holds.

    With a tolerance also while no more than that lie; with the policy "reject" also if one thing is wrong, or one more, until
    that is found out and afterwards (see docs/design.md).

    Attributes:
        policy: What to do when measurements are proved to disagree: "raise"; or "reject" what is wrong: go on with what is
            known whichever one thing that is, until it is found out, then without that.
        each_alone: Whether in a conflict each suspect is tried alone, so that there is a proof of each, as certificates ask
            for; otherwise those whom the conflict does not name are tried together, which takes less time.
    """

    policy: Policy = "raise"
    each_alone: bool = field(default=False, metadata=checked(instance, "each_alone", bool))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.policy, str) or self.policy not in get_args(Policy):
            raise InvalidInput(f"a policy among {', '.join(get_args(Policy))}", shown(self.policy))

    def predict(self, belief: Belief, time: float, odometry: Odometry | None = None) -> Belief:
        """Return the belief at a later time [s]; raises `Inconsistent`, too, if a robot has left the arena for sure.

        That only with the policy "raise".
        """
        if not self._diagnoses(belief):
            return super().predict(belief, time, odometry)
        self.team.check_belief(belief, Belief, "headings")
        time = self.team.check_motion(belief.time, time, odometry)
        there, diagnosis = belief.guarantee.of_those_there(odometry), belief.diagnosis or Diagnosis()
        if diagnosis.hypotheses:
            self.on_phase("predict")
            return judging.predicted(self._strict(never), belief, diagnosis, time, there)
        return quiet.predicted(self._strict(never), belief, diagnosis, time, there, raises=self.policy == "raise")

    def update(self, belief: Belief, measurements: Sequence[Measurement] = ()) -> Belief:
        """Return the belief after merging measurements taken at its time, with every region searched anew.

        Their order, and how they are split into records, makes no difference to any bit.

        Raises `Inconsistent` if they are proved to exclude one another or what is known, as some bound is broken; with the
        policy "reject" never.
        """
        if not self._diagnoses(belief):
            return super().update(belief, measurements)
        self.on_phase("headings")
        self.team.check_belief(belief, Belief, "headings")
        records = self.team.checked(belief.time, measurements, belief.guarantee.away)
        strict = self._strict(self.budget.begin() if self.budget else never)
        diagnosis = belief.diagnosis or Diagnosis()
        if diagnosis.hypotheses:
            kept = without_all([trial.suspect for trial in diagnosis.aside], records)
            return judging.updated(strict, belief, diagnosis, kept)
        return quiet.updated(strict, belief, diagnosis, records, raises=self.policy == "raise")

    def placed(self, belief: Belief, robot: int, polygon: Polygon | None, heading: AngularIntervals | None = None) -> Belief:
        """Return the belief in which a robot is somewhere now, as that of the strict filter is, in each case that can be."""
        return self._in_each_case(belief, lambda case: super(SetMembershipFilter, self).placed(case, robot, polygon, heading))

    def changed(self, belief: Belief, change: Change) -> Belief:
        """Return the belief in which a robot is `placed`, or in which one has left, in each case that can be."""
        return self._in_each_case(belief, lambda case: super(SetMembershipFilter, self).changed(case, change))

    def relative(self, belief: Belief, i: Integers, j: Integers) -> Polygons:
        """Return (g) polygons that contain x_j - x_i of robots i, j (g,) (eq. 3) [m]; `InvalidInput` if these are no pairs."""
        cases = belief.diagnosis.hypotheses if belief.diagnosis else ()
        if not cases:
            return super().relative(belief, i, j)
        return hulls_of([super(SetMembershipFilter, self).relative(case.belief, i, j) for case in cases])

    def _diagnoses(self, belief: Belief) -> bool:
        return self.policy == "reject" or getattr(belief, "diagnosis", None) is not None

    def _together(self, belief: Belief, frames: Sequence[Frame]) -> Belief | None:
        """Return the belief after several instants at once; None where something is in doubt, too, or on trial."""
        if not self._diagnoses(belief):
            return super()._together(belief, frames)
        diagnosis = belief.diagnosis or Diagnosis()
        if diagnosis.hypotheses or diagnosis.aside or diagnosis.suspended:
            return None
        found = super()._together(belief.alone, frames)
        return found and replace(found, diagnosis=quiet.remembered(diagnosis, belief, tuple(frames)))

    def _in_each_case(self, belief: Belief, change: Callable[[Belief], Belief]) -> Belief:
        """Return a belief after a change, in each case that can be; what came before it is not tried again."""
        diagnosis = belief.diagnosis
        if diagnosis is None:
            return change(belief)
        cases = tuple(replace(each, belief=change(each.belief)) for each in diagnosis.hypotheses)
        aside = tuple(replace(trial, belief=trial.belief and change(trial.belief)) for trial in diagnosis.aside)
        now = replace(diagnosis, recent=(), hypotheses=cases, aside=aside)
        if not cases:
            return replace(change(belief.alone), diagnosis=now)
        cover = cover_of([each.belief for each in cases])
        assuming = assumption(self._strict(never), now.since, now.suspects, now.aside)
        return replace(cover, guarantee=cover.guarantee.under(assuming), diagnosis=now)

    def _strict(self, is_over: IsOver) -> Strict:
        """Return what the strict filter does, until time is over."""
        named = super()._named

        def updated(belief: Belief, records: tuple[Measurement, ...]) -> Belief:
            return self._updated(belief, records, is_over)

        def briefly(belief: Belief, records: tuple[Measurement, ...]) -> Belief:
            return replace(self, cells=0, pairs=0, corners=False)._updated(belief, records, is_over)

        def predicted(belief: Belief, time: float, odometry: Odometry | None) -> Belief:
            return self._predicted(replace(belief, moved=None), (time, odometry), self.team.arena)

        known = self.team.robots, self.each_alone, self.team.words
        return Strict(*known, self._anywhere, super().predict, predicted, updated, briefly, named)

    def _anywhere(self, belief: Belief, robot: int) -> Belief:
        """Return the belief in which a robot is anywhere in the arena; where it is open, far around all that is known."""
        lower, upper = np.where(np.isfinite(self.team.arena), self.team.arena, anywhere(belief, self.team))
        return super().placed(belief, robot, Polygon.box(lower, upper))
