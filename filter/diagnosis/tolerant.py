"""The filter that tolerates lies: a belief for each case of who lies, side by side, and what holds in all of them."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from filter.arrays import Array, Integers
from filter.diagnosis.cover import cover_of, united
from filter.diagnosis.voting import VotingFilter
from filter.errors import Inconsistent, InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.around import hulls_of
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.projection.claims import Outlines
from filter.projection.stop import IsOver
from filter.records.frame import Frame
from filter.records.measurements import Measurement
from filter.records.presence import Change
from filter.sets.belief import Alternative, Alternatives, Belief, Tried
from filter.sets.conflict import Motion
from filter.sets.suspect import Tolerated


@dataclass(frozen=True, eq=False)
class TolerantFilter(VotingFilter):
    """A `Filter` that is the strict one, or that goes on while no more lie than it tolerates."""

    def start(self, time: float, positions: Sequence[Polygon | None], headings: AngularIntervals | None = None) -> Belief:
        """Return the belief before any measurement; `InvalidInput` also if a polygon is wholly outside the arena."""
        belief = super().start(time, positions, headings)
        told = "" if self.tolerance is None else str(self.tolerance)
        return replace(belief, guarantee=replace(belief.guarantee, tolerating=told))

    def placed(self, belief: Belief, robot: int, polygon: Polygon | None, heading: AngularIntervals | None = None) -> Belief:
        """Return the belief in which a robot is somewhere now, as that of the strict filter is, in each case that can be."""
        strictly = super().placed
        return self._in_each(belief, lambda case: strictly(case, robot, polygon, heading))

    def changed(self, belief: Belief, change: Change) -> Belief:
        """Return the belief in which a robot is `placed`, or in which one has left, in each case that can be."""
        strictly = super().changed
        return self._in_each(belief, lambda case: strictly(case, change))

    def relative(self, belief: Belief, i: Integers, j: Integers) -> Polygons:
        """Return (g) polygons that contain x_j - x_i of robots i, j (g,) (eq. 3) [m]; `InvalidInput` if these are no pairs."""
        if belief.alternatives is None:
            return super().relative(belief, i, j)
        return hulls_of([super(TolerantFilter, self).relative(one.belief, i, j) for one in belief.alternatives.each])

    def _predicted(self, belief: Belief, motion: Motion, arena: Array) -> Belief:
        """Return the belief after a motion in each case that can be; where the window ends, these cases are one before."""
        self._check(belief)
        strictly, begun = super()._predicted, self._begun_for(belief, motion[0], motion[0])
        known = begun.alternatives
        if known is None:
            return strictly(begun, motion, arena)
        living = _living(known, lambda one: strictly(one.belief, motion, arena), motion[0])
        if known.united:
            return replace(living.each[0].belief, alternatives=replace(living, tried=known.tried, united=known.united))
        around = strictly(replace(begun, alternatives=None), motion, arena)
        return replace(around, alternatives=living)

    def _updated(self, belief: Belief, measurements: tuple[Measurement, ...], is_over: IsOver) -> Belief:
        """Merge and project in each case that can be, those among them whose suspects are heard for the first time."""
        self._check(belief)
        if self.tolerance is None or self.tolerance.is_by_votes:
            return super()._updated(belief, measurements, is_over)
        strictly, believed = super()._updated, self.tolerance.believed
        born = self._born(belief, [measurements])
        living = _living(born, lambda one: strictly(one.belief, believed(one.lying, measurements), is_over), belief.time)
        return self._covered(living, belief.guarantee)

    def _together(self, belief: Belief, frames: Sequence[Frame]) -> Belief | None:
        """Return the belief after several instants at once, in each case that can be; None where a step for each says more."""
        self._check(belief)
        if self.tolerance is None:
            return super()._together(belief, frames)
        if self.tolerance.is_by_votes:
            return None
        for frame in frames:  # what is not believed of them has to be right in form, too
            self.team.checked(frame.time, frame.measurements, belief.guarantee.away)
        if frames[-1].time - belief.time >= self.tolerance.window:
            return None
        begun = self._begun_for(belief, frames[-1].time, belief.time)
        born, found = self._born(begun, [tuple(frame.measurements) for frame in frames]), list[Alternative]()
        for one in born.each:
            left = [
                replace(frame, measurements=self.tolerance.believed(one.lying, tuple(frame.measurements))) for frame in frames
            ]
            together = super()._together(one.belief, left)
            if together is None:
                return None
            found.append(replace(one, belief=together))
        return self._covered(replace(born, each=tuple(found), tried=()), begun.guarantee)

    def _excludes(self, belief: Belief, motion: Motion | None, arena: Array, measurements: tuple[Measurement, ...]) -> bool:
        """Return whether what holds in every case, after a motion, is proved to exclude measurements."""
        return super()._excludes(replace(belief, alternatives=None, votes=None), motion, arena, measurements)

    def _begun_for(self, belief: Belief, time: float, since: float) -> Belief:
        """Return a belief that can be taken along to a time [s]: where a window ends before, with one case, since another."""
        known = belief.alternatives
        if known is None or (self.tolerance is not None and time - known.since < self.tolerance.window):
            return belief
        together, proofs = united([one.belief for one in known.each], self._seen_from, self.slices)
        kept = self._pruned(together.polytope)
        together = replace(together, polytope=kept, guarantee=belief.guarantee).compact()
        why = ((proof,) for proof in proofs) if proofs else ((),) * len(known.each)
        tried = (Tried("", "", one.lying, (replace(one.belief, proofs=of),)) for one, of in zip(known.each, why, strict=True))
        alone = Alternatives(since, (Alternative((), together),), tried=tuple(tried), united=together)
        return replace(together, alternatives=alone)

    def _seen_from(self, belief: Belief, pairs: tuple[Integers, Integers]) -> Outlines:
        """Return polygons that contain x_j - x_i of pairs i < j (g), in one case, and why."""
        return self._projector.pairs(belief.polytope, pairs).outlines

    def _born(self, belief: Belief, instants: Iterable[tuple[Measurement, ...]]) -> Alternatives:
        """Return the cases before some instants: with those who are heard for the first time among who may lie."""
        known = belief.alternatives or Alternatives(belief.time, (Alternative((), belief),))
        if self.tolerance is None:
            return known
        each, heard = list(known.each), set(known.heard)
        for suspect in self.tolerance.heard(instants, known.since):
            if suspect not in heard:
                each += [Alternative((*one.lying, suspect), one.belief) for one in each if len(one.lying) < self.tolerance.q]
                heard.add(suspect)
        return replace(known, each=tuple(each), heard=frozenset(heard))

    def _covered(self, living: Alternatives, guarantee: Guarantee) -> Belief:
        """Return what holds in all cases, under the guarantee from before, and tell if it is proved that somebody lies."""
        events = tuple(dict.fromkeys(event for one in living.each for event in one.belief.events))
        first, *others = living.each
        around = cover_of([one.belief for one in living.each]) if others else replace(first.belief, events=())
        around = replace(around, proofs=()) if first.lying else around
        if () not in living.cases and living.cases != living.told:
            events = (Tolerated(around.time, living.since, living.cases), *events)
            living = replace(living, told=living.cases)
        return replace(around, events=events, alternatives=living, guarantee=guarantee)

    def _in_each(self, belief: Belief, change: Callable[[Belief], Belief]) -> Belief:
        """Return a belief after a change, in each case that can be."""
        known = belief.alternatives
        if known is None:
            return change(belief)
        each = tuple(replace(one, belief=change(one.belief)) for one in known.each)
        return replace(change(replace(belief, alternatives=None)), alternatives=replace(known, each=each))

    def _check(self, belief: Belief) -> None:
        """Raise `InvalidInput` for a belief that holds under another tolerance: nothing could be said of it under this one."""
        told, own = belief.guarantee.tolerating, "" if self.tolerance is None else str(self.tolerance)
        if told != own:
            raise InvalidInput(f"a belief that holds {own or 'without a tolerance'}", told or "one without a tolerance")


def _living(known: Alternatives, step: Callable[[Alternative], Belief], time: float) -> Alternatives:
    """Return the cases that a step to a time [s] does not exclude by proof; raises `Inconsistent` if that is every one."""
    living, tried, errors = list[Alternative](), list[Tried](), list[Inconsistent]()
    for one in known.each:
        try:
            living.append(replace(one, belief=step(one)))
        except Inconsistent as error:
            errors.append(error)
            tried.append(Tried("", "", one.lying, (), end=(time, error.evidence)))
        else:
            tried.append(Tried("", "", one.lying, (living[-1].belief,)))
    if not living:
        raise errors[0]
    return replace(known, each=tuple(living), tried=tuple(tried), united=None)
