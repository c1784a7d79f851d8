"""What is known at one time: the polytope, the headings, a region for each robot, why, and what happened on the way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from filter.arrays import Array, whole_number
from filter.cameras.offsets import Offsets
from filter.geometry.angles import AngularIntervals
from filter.guarantee import Guarantee
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources, in_order
from filter.poses.slices import Slices
from filter.poses.votes import Ballots
from filter.projection.fallback import Fallback
from filter.records.frame import Frame
from filter.records.odometry import Odometry
from filter.sets.proof import Bounded, Evidence, Proof, causes_of
from filter.sets.regions import Regions
from filter.sets.suspect import Confirmed, Doubted, Judged, Late, Passed, StartsOver, Suspect, Tolerated, Turned

Event = Doubted | Judged | Passed | StartsOver | Confirmed | Tolerated | Turned | Late | Fallback
Used = Mapping[tuple[str, int, int], int]  # at how many instants what each says was merged, tests counting for several


@dataclass(frozen=True, eq=False)
class Moved:
    """What a prediction was made from, so that the next update can say whether the motion is at fault.

    Attributes:
        before: The belief before; what that was made from is left out, or all would be kept for ever.
        odometry: How the robots moved since, or None where nothing was measured of that.
    """

    before: Belief
    odometry: Odometry | None


@dataclass(frozen=True, eq=False)
class Belief:
    """What the filter knows at one time.

    Attributes:
        time: When [s].
        polytope: Where the whole team can be.
        headings: (n) arcs that contain the robots' headings.
        sources: What produced the rows and the edges.
        guarantee: In force, if need be under the assumption that one thing alone is wrong; suspended where more is.
        found: (n) where each robot is, as the last update found; None at the start and after a prediction.
        events: What came into doubt, who was judged, and where walks and solvers failed.
        proofs: Why edges of regions, boxes and pairs hold, round after round; before them what was proved by cases, and read.
        moved: What a prediction was made from; None at the start, after an update, and if somebody came or left.
        slices: The poses of robots whose headings are wide, position and heading together.
        alternatives: What is known in each case of who lies, if that is tolerated, also of pairs and poses; at the start None.
        votes: Which votes on poses there were, of a filter that holds the truth although one of them is wrong; else None.
        diagnosis: What a filter that goes on after a conflict keeps for that; None for one that raises.
        cameras: What motion says of the robots' cameras, by estimate, of a filter that asks; nothing of it is in a region.
    """

    time: float
    polytope: Polytope
    headings: AngularIntervals
    sources: Sources
    guarantee: Guarantee
    found: Regions | None = None
    events: tuple[Event, ...] = ()
    proofs: tuple[Evidence, ...] = ()
    moved: Moved | None = None
    slices: Slices = field(default_factory=Slices.none)
    alternatives: Alternatives | None = None
    votes: Ballots | None = None
    diagnosis: Diagnosis | None = None
    cameras: Offsets | None = None

    @property
    def aside(self) -> tuple[Suspect, ...]:
        """Who was found guilty and is not listened to, until trusted again."""
        return tuple(trial.suspect for trial in self.diagnosis.aside) if self.diagnosis else ()

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Who can be wrong, in the time of a doubt, or where it is proved that somebody is who is tolerated; else nobody."""
        return (self.diagnosis.suspects if self.diagnosis else ()) or (self.alternatives.suspects if self.alternatives else ())

    @property
    def agrees(self) -> bool:
        """Whether it can be that nobody lies of those whose lies are tolerated, in each case that is in doubt."""
        if self.diagnosis and self.diagnosis.hypotheses:
            return all(each.belief.agrees for each in self.diagnosis.hypotheses)
        told = any(isinstance(event, Tolerated) for event in self.events)
        return not told and (self.alternatives is None or () in self.alternatives.cases)

    @property
    def alone(self) -> Belief:
        """What is known, without what is kept for a diagnosis."""
        return replace(self, diagnosis=None) if self.diagnosis else self

    @cached_property
    def regions(self) -> Regions:
        """(n) where each robot is: as the last update found, or else as the rows on each robot alone tell at a glance."""
        return self.found or Regions.at_a_glance(self.polytope)

    def compact(self) -> Belief:
        """Return the same with a table that holds only the sources that rows, edges and boxes name."""
        rows, origin = self.polytope.constraints, self.polytope.origin
        cause = self.found.cause if self.found else origin
        used = np.bincount(np.concatenate([rows.source, origin, cause]), minlength=len(self.sources)) > 0
        now = np.cumsum(used) - 1
        polytope = replace(self.polytope, constraints=rows.with_sources(now[rows.source]), origin=now[origin])
        found = replace(self.found, cause=now[cause]) if self.found else None
        return replace(self, polytope=polytope, found=found, sources=self.sources.select(np.flatnonzero(used)))

    @property
    def constraints(self) -> Constraints:
        """The polytope's rows."""
        return self.polytope.constraints

    def proofs_of(self, what: Bounded) -> Iterator[Proof]:
        """Yield the proofs of one kind of claims, one for each round of the last update."""
        return (proof for proof in self.proofs if isinstance(proof, Proof) and proof.of == what)

    def causes(self, robot: int, edge: int) -> tuple[Source, ...]:
        """Return what an edge of a robot's outer polygon was proved from, one step back; `InvalidInput` if there is none."""
        region = self.regions[whole_number("robot", robot, 0, len(self.regions) - 1)]
        place = whole_number("edge", edge, 0, len(region.causes) - 1)
        proofs = tuple(proof for proof in self.proofs if isinstance(proof, Proof))
        last = {self.sources[int(number)] for number in region.causes[place]}
        return tuple(sorted(causes_of(proofs, self.time, (WORLD, robot, region.outer.normals[place]), last), key=in_order))


@dataclass(frozen=True, eq=False)
class Alternative:
    """What is known if some suspects lie and nobody else does.

    Attributes:
        lying: These; nobody where all is right.
        belief: What then is known.
    """

    lying: tuple[Suspect, ...]
    belief: Belief


@dataclass(frozen=True, eq=False)
class Alternatives:
    """What is known in each case of who lies, since they were begun.

    Attributes:
        since: When that was [s].
        each: The cases that are not proved to be impossible.
        heard: Who has spoken since then: those who have not are in no case of their own.
        told: The cases when it was last told that somebody lies.
        tried: What came of each in an update of one instant; or what each said of pairs of those that are one now: `united`.
    """

    since: float
    each: tuple[Alternative, ...]
    heard: frozenset[Suspect] = frozenset()
    told: tuple[tuple[Suspect, ...], ...] = ()
    tried: tuple[Tried, ...] = ()
    united: Belief | None = None

    @property
    def cases(self) -> tuple[tuple[Suspect, ...], ...]:
        """Who lies, in each case; () is that nobody does."""
        return tuple(one.lying for one in self.each)

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Who can lie, once it is proved that somebody does."""
        return tuple(sorted({one for case in self.cases for one in case if () not in self.cases}, key=lambda one: one.who))


@dataclass(frozen=True, eq=False)
class Recent:
    """What was given to a filter at an instant, or at several at once.

    Attributes:
        before: What was known before, without a diagnosis, and without what that was made from: nothing older is kept alive.
        frames: What came then, of which what was not listened to is left out.
    """

    before: Belief
    frames: tuple[Frame, ...]


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What is known if one of some suspects is wrong and nothing else: they are one as long as they leave out the same.

    Attributes:
        suspects: One of these.
        belief: What then is known.
        used: What was merged since the doubt began.
        is_over: Whether it was wrong, and is right again by evidence: it is listened to.
        agreed: Whether nobody had to lie meanwhile of those whose lies are tolerated: else it is no evidence for anybody.
        fits: At how many instants in a row what its suspects say would have fitted, too.
        name: By which those that follow from it tell it from others.
        unites: Names of those that it was just made from, as it contains each of them; none where it follows from one.
        anew: Robots that were anywhere since the last update.
    """

    suspects: tuple[Suspect, ...]
    belief: Belief
    used: Used = field(default_factory=dict)
    is_over: bool = False
    agreed: bool = True
    fits: int = 0
    name: str = ""
    unites: tuple[str, ...] = ()
    anew: frozenset[int] = frozenset()


@dataclass(frozen=True, eq=False)
class Tried:
    """What came of a hypothesis, or of a case of who lies, in one step: what is needed to prove it again.

    Attributes:
        name: The hypothesis; a case has none.
        parent: The one that it follows from; empty for what was known before the first instant.
        suspects: One of these is wrong in a hypothesis; all of these lie in a case.
        beliefs: After each instant that it was taken through, with their proofs.
        anew: Robots that were anywhere at the last instant.
        end: When nothing was left of it [s], and why; None if something is.
        is_again: Whether its suspects are right again, and what they say was heard, too; without beliefs if that was nothing.
    """

    name: str
    parent: str
    suspects: tuple[Suspect, ...]
    beliefs: tuple[Belief, ...]
    anew: frozenset[int] = frozenset()
    end: tuple[float, tuple[Evidence, ...]] | None = None
    is_again: bool = False


@dataclass(frozen=True, eq=False)
class Trial:
    """A suspect that was found guilty, whose readings are looked at from aside; or a robot, by its past, that starts over.

    Attributes:
        suspect: Which.
        since: When the trial began: all has agreed since [s].
        belief: What would be known if it were right since then, where that is more than is known; else None.
        used: What was merged since then.
        metres: (n,) how far the robots have driven since then [m].
    """

    suspect: Suspect
    since: float
    belief: Belief | None
    used: Used
    metres: Array


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What a filter keeps to find out what is wrong.

    Attributes:
        recent: The last instants, to be tried again; none in the time of a doubt.
        hypotheses: What is known in each case, in the time of a doubt; else none.
        conflict: What is proved to exclude one another, then.
        since: When the doubt began [s].
        metres: (n,) how far the robots have driven since then [m].
        instants: How many updates there were since then.
        by_proof: Whether all who are no longer suspected would leave a contradiction.
        aside: Who is not listened to.
        suspended: Robots that start over.
        tried: What came of each hypothesis in the last step, in the time of a doubt.
        left: The one that was left, if the doubt has just ended.
    """

    recent: tuple[Recent, ...] = ()
    hypotheses: tuple[Hypothesis, ...] = ()
    conflict: tuple[Source, ...] = ()
    since: float = 0.0
    metres: Array | None = None
    instants: int = 0
    by_proof: bool = True
    aside: tuple[Trial, ...] = ()
    suspended: tuple[Trial, ...] = ()
    tried: tuple[Tried, ...] = ()
    left: Hypothesis | None = None

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """Who can be wrong, or have been."""
        return tuple(sorted({one for each in self.hypotheses for one in each.suspects}, key=lambda suspect: suspect.who))

    @property
    def suspected(self) -> tuple[Suspect, ...]:
        """Who can be wrong still."""
        found = (one for each in self.hypotheses if not each.is_over for one in each.suspects)
        return tuple(sorted(found, key=lambda suspect: suspect.who))
