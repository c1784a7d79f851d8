"""Corral: a dynamic set-membership filter for moving robot teams.

Read the modules in this order: errors, arrays, compiled, angles, plane, polygon, polygons, constraints, lp, scaling, solvers,
polytope, reference, measurements, team, sensing, motion, projection, search, pruning, simplex, shadow, exact, budget,
projector, window, windowed, outlines, windows, region, belief, headings, boxes, corners, regions, pairs, rejection,
set_membership; slices, sightings, hypotheses, cuts, voting, trust, alignment, estimating, robust_belief, leaving, merging,
robust, lag.
"""

from filter.alignment import Alignment
from filter.angles import AngularIntervals
from filter.belief import Belief, Event, Fallback, Proof, Rejected, Source
from filter.budget import Budget
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder, Unbounded
from filter.lag import FixedLag, Lagged
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.polygon import Polygon
from filter.projection import Stop
from filter.region import Region, Regions
from filter.robust import RobustFilter
from filter.robust_belief import Disagreement, Distrusted, Late, Restarted, RobustBelief, Turned
from filter.set_membership import SetMembershipFilter
from filter.team import Team
from filter.trust import Suspicion
from filter.voting import Rules
from filter.window import Window

__all__ = [
    "Alignment",
    "AngularIntervals",
    "Bearing",
    "Belief",
    "Budget",
    "Compass",
    "CorralError",
    "Disagreement",
    "Distrusted",
    "Event",
    "Fallback",
    "FixedLag",
    "Inconsistent",
    "InvalidInput",
    "Lagged",
    "Late",
    "Measurement",
    "Odometry",
    "OutOfOrder",
    "Polygon",
    "Proof",
    "Range",
    "Region",
    "Regions",
    "Rejected",
    "Restarted",
    "RobustBelief",
    "RobustFilter",
    "Rules",
    "SetMembershipFilter",
    "Source",
    "Stop",
    "Suspicion",
    "Team",
    "Turned",
    "Unbounded",
    "Window",
]
