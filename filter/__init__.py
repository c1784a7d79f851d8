"""Corral: a dynamic set-membership filter for moving robot teams.

Read in this order, rooms with a slash: errors, arrays, workers, compiled, geometry/, measurements, frame, team, linear/,
sensing/, projection/, sets/, robust/, lag, ekf, watch, warm_up.
"""

from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder, Unbounded
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.lag import FixedLag, Lagged
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.projection.budget import Budget
from filter.projection.polygons_of import Stop
from filter.projection.window import Window
from filter.robust.belief import Disagreement, Distrusted, Late, Restarted, RobustBelief, Turned
from filter.robust.cameras import Alignment
from filter.robust.robust_filter import RobustFilter
from filter.robust.trust import Suspicion
from filter.robust.votes import Rules
from filter.sets.belief import Belief, Event, Fallback, Proof, Rejected, Source
from filter.sets.regions import Region, Regions
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team
from filter.warm_up import warm_up

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
    "warm_up",
]
