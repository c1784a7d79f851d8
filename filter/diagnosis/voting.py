"""The filter that holds the truth although one vote on each robot's pose is wrong in any window: what it and a body said."""

from dataclasses import dataclass, field, replace

import numpy as np

from filter.arrays import Array, Integers, checked, instance
from filter.diagnosis.tolerance import Tolerance
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import WORLD, Constraints
from filter.linear.sources import Source
from filter.poses.cells import Most, Told
from filter.poses.slices import COUNT, DIRECTIONS, Slices
from filter.poses.votes import Ballots, Polled, Polling
from filter.projection.stop import IsOver
from filter.records.measurements import Compass, Measurement, Position
from filter.records.relative import RelativeHeading
from filter.sensing.arms import Arms
from filter.sensing.headings import narrowed_headings
from filter.sensing.readings import Readings
from filter.sets.belief import Belief
from filter.sets.conflict import Motion
from filter.sets.proof import After
from filter.sets.set_membership import StrictFilter
from filter.sets.suspect import Suspect, Tolerated


@dataclass(frozen=True, eq=False)
class VotingFilter(StrictFilter):
    """A `Filter` that is the strict one, or that lets robots measured and seen vote on where they are.

    Attributes:
        tolerance: Who may lie, and how many at a time; None for nobody.
    """

    tolerance: Tolerance | None = field(default=None, metadata=checked(instance, "tolerance", Tolerance, type(None)))

    def _predicted(self, belief: Belief, motion: Motion, arena: Array) -> Belief:
        """Return the belief after a motion, with the votes that there were."""
        return replace(super()._predicted(belief, motion, arena), votes=belief.votes)

    def _updated(self, belief: Belief, measurements: tuple[Measurement, ...], is_over: IsOver) -> Belief:
        """Merge and project; sightings are votes on poses, all other measurements are believed."""
        if self.tolerance is None or not self.tolerance.is_by_votes:
            return super()._updated(belief, measurements, is_over)
        believed = tuple(record for record in measurements if isinstance(record, Compass | Position))
        polled = self._polled(belief, measurements, self.tolerance.window)
        with After(polled.proofs):
            found = super()._updated(polled, believed, is_over)
        events, proofs = (*polled.events, *found.events), (*polled.proofs, *found.proofs)
        return replace(found, slices=polled.slices, votes=polled.votes, events=events, proofs=proofs)

    def _polled(self, belief: Belief, records: tuple[Measurement, ...], window: float) -> Belief:
        """Return what votes leave of poses, with the hulls of it as rows; raises `Inconsistent` if that is nothing."""
        heard = tuple(record for record in records if not isinstance(record, RelativeHeading))
        readings = Readings.of(belief.time, heard, mountings=self.team.mountings)
        headings = narrowed_headings(belief.headings, readings, AngularIntervals.circles(len(readings.bearings.robot)))
        told = Told.of(readings, headings, self.tangent_spacing, Arms.of(readings, headings, len(headings)))
        seer = np.concatenate([readings.bearings.robot, readings.ranges.robot])[told.reading]
        poll = Polling(belief.polytope, told, seer, self.team.landmarks, Most(self.cells, self.slices))
        votes, before = poll.opened(belief.votes, belief.slices, belief.time, window)
        cast = poll.cast(before)
        looks, reach = _hulls(slices := cast.slices, headings, readings, poll.robots)
        narrower = headings.replaced(poll.robots, looks)
        wrong = slices.contradicted()
        events = tuple(_told(belief.time, slices, votes, robot) for robot in wrong.tolist())
        since, slices = poll.ended(votes, slices, wrong)
        polled = Polled(poll, readings, belief.sources, belief.slices, votes, cast, slices, narrower)
        known = replace(belief, headings=narrower, proofs=(polled,))
        found = replace(known, slices=slices, votes=since, events=events)
        return _with_rows(found, poll.robots, reach)


def _hulls(slices: Slices, headings: AngularIntervals, readings: Readings, robots: Integers) -> tuple[AngularIntervals, Array]:
    """Return what is left of some of (n) headings, (k) [rad], and supports (k, COUNT) around slices of robots (k,) [m].

    Raises `Inconsistent` if nothing is left of a robot's poses.
    """
    nowhere = np.setdiff1d(robots, slices.robot)
    if not len(nowhere):
        arcs, reach = slices.hulls(robots)
        looks = headings[robots].intersection(arcs)
        if not looks.empty.any():
            return looks, reach
        nowhere = robots[looks.empty]
    robot, time = int(nowhere[0]), readings.ranges.time
    known = Source("region", time, robot), Source("heading", time, robot)
    raise Inconsistent(f"at {time} s", [*known, *readings.concerning(robot)], robot)


def _told(time: float, slices: Slices, votes: Ballots, robot: int) -> Tolerated:
    """Return that it is proved by a time [s] that one of the votes on a robot is wrong, of those that its slices do without."""
    since, labels = float(votes.since[robot]), np.unique(slices.of(robot).vote).tolist()
    suspects = (Suspect("sighting", *pair, since) for pair in votes.sightings(robot, labels))
    return Tolerated(time, since, tuple((suspect,) for suspect in suspects))


def _with_rows(belief: Belief, robots: Integers, reach: Array) -> Belief:
    """Return a belief in which robots (k,) are behind half-planes in the directions of slices, by supports (k, COUNT) [m]."""
    table, numbers = belief.sources.extended("cells", belief.time, robots)
    normals, whose, source = np.tile(DIRECTIONS, (len(robots), 1)), np.repeat(robots, COUNT), np.repeat(numbers, COUNT)
    rows = Constraints(np.full(len(whose), WORLD), whose, normals, reach.ravel(), source)
    polytope = belief.polytope.with_constraints(Constraints.concatenate([belief.constraints, rows]))
    return replace(belief, polytope=polytope, sources=table)
