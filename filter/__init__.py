"""Corral: a dynamic set-membership filter for moving robot teams.

Read the modules in this order: errors, arrays, angles, plane, polygon, constraints, lp, scaling, solvers, polytope,
reference, measurements, team, sensing, motion, projection, search, pruning, simplex, shadow, exact, projector, window,
windows, belief, regions, rejection, set_membership.
"""

from filter.angles import AngularIntervals
from filter.belief import Belief, Event, Fallback, Proof, Region, Rejected, Source
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder, Unbounded
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.polygon import Polygon
from filter.projection import Stop
from filter.set_membership import SetMembershipFilter
from filter.team import Team
from filter.window import Window

__all__ = [
    "AngularIntervals",
    "Bearing",
    "Belief",
    "Compass",
    "CorralError",
    "Event",
    "Fallback",
    "Inconsistent",
    "InvalidInput",
    "Measurement",
    "Odometry",
    "OutOfOrder",
    "Polygon",
    "Proof",
    "Range",
    "Region",
    "Rejected",
    "SetMembershipFilter",
    "Source",
    "Stop",
    "Team",
    "Unbounded",
    "Window",
]
