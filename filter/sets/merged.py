"""What merging came to, and what it has read on the way."""

from dataclasses import dataclass

from filter.arrays import Frozen, Integers
from filter.geometry.angles import AngularIntervals
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.poses.cells import Cases
from filter.poses.slices import Slices
from filter.sensing.arms import Arms
from filter.sensing.readings import Readings
from filter.sensing.since import Moves


@dataclass(frozen=True, eq=False)
class Directions(Frozen):
    """What one pass read the directions of targets from, at a glance.

    Attributes:
        readings: Of whom.
        sources: What produced the rows of these polytopes:
        known: for bearings, from which the headings follow;
        seen: for ranges, with the rows of bearings.
        headings: (n) after it [rad].
        arcs: (r) the directions of ranges [rad].
        moves: Where robots have gone since the readings; None if these are of one instant.
        arms: From the places of sensors to the centres of robots; None if all readings are taken at centres.
        before: The same as it was known for the directions of bearings.
        is_torn: Whether of some robot's heading, or of its poses, nothing is left; the headings are those before, then.
    """

    readings: Readings
    sources: Sources
    known: Polytope
    seen: Polytope
    headings: AngularIntervals
    arcs: AngularIntervals
    moves: Moves | None = None
    arms: Arms | None = None
    before: Arms | None = None
    is_torn: bool = False


@dataclass(frozen=True, eq=False)
class Merged(Frozen):
    """What came of it.

    Attributes:
        polytope: Where the team is, with the rows of what was measured.
        headings: (n) the robots' headings [rad].
        evidence: What was found in cells, and then what each pass that counts has read directions from.
        wide: (c,) robots that are worth cells. They were found in cells, if the readings are of one instant and time was left.
        slices: Of the poses of robots whose headings are wide.
    """

    polytope: Polytope
    headings: AngularIntervals
    slices: Slices
    evidence: tuple[Cases | Directions, ...]
    wide: Integers
