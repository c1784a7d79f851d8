"""Corral: a dynamic set-membership filter for moving robot teams.

Read the modules in this order: errors, arrays, compiled, angles, plane, polygon, polygons, constraints, lp, scaling, solvers,
polytope, reference, measurements, team, sensing, motion, projection, search, pruning, simplex, shadow, exact, budget,
projector, window, windowed, outlines, windows, region, belief, headings, boxes, regions, rejection, set_membership.
"""

from filter.angles import AngularIntervals
from filter.belief import Belief, Event, Fallback, Proof, Rejected, Source
from filter.budget import Budget
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder, Unbounded
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.polygon import Polygon
from filter.projection import Stop
from filter.region import Region, Regions
from filter.set_membership import SetMembershipFilter
from filter.team import Team
from filter.window import Window

__all__ = [
    "AngularIntervals",
    "Bearing",
    "Belief",
    "Budget",
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
    "Regions",
    "Rejected",
    "SetMembershipFilter",
    "Source",
    "Stop",
    "Team",
    "Unbounded",
    "Window",
]
