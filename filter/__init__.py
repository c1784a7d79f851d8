"""Corral: a dynamic set-membership filter for moving robot teams.

Everything that a user names is here: `from filter import SetMembershipFilter, Team`. What is not here may change without
notice.

Read in this order, rooms with a slash: errors, arrays, compiled, geometry/, measurements, frame, team, linear/, sensing/,
projection/, sets/, robust/, follow, lag, ekf, watch.
"""

from filter.arrays import Array, Floats, Integers, Mask
from filter.ekf import ExtendedKalmanFilter, GaussianBelief, NoiseModel
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder, OutOfRange, Unbounded
from filter.follow import AnyBelief, Filter, Step, follow
from filter.frame import Frame, Truth
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.lag import FixedLag, Lagged
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.projection.budget import Budget
from filter.projection.polygons_of import Stop
from filter.projection.window import Window
from filter.robust.belief import Disagreement, Distrusted, Late, Restarted, RobustBelief, RobustEvent, Turned
from filter.robust.cameras import Alignment
from filter.robust.robust_filter import RobustFilter
from filter.robust.trust import Suspicion
from filter.robust.votes import Rules
from filter.sets.belief import Belief, Event, Fallback, Proof, Rejected, Source
from filter.sets.regions import Region, Regions
from filter.sets.set_membership import PHASES, Policy, SetMembershipFilter
from filter.team import Team
from filter.watch import Alarm, watch

__all__ = [
    "PHASES",
    "Alarm",
    "Alignment",
    "AngularIntervals",
    "AnyBelief",
    "Array",
    "Bearing",
    "Belief",
    "Budget",
    "Compass",
    "CorralError",
    "Disagreement",
    "Distrusted",
    "Event",
    "ExtendedKalmanFilter",
    "Fallback",
    "Filter",
    "FixedLag",
    "Floats",
    "Frame",
    "GaussianBelief",
    "Inconsistent",
    "Integers",
    "InvalidInput",
    "Lagged",
    "Late",
    "Mask",
    "Measurement",
    "NoiseModel",
    "Odometry",
    "OutOfOrder",
    "OutOfRange",
    "Policy",
    "Polygon",
    "Proof",
    "Range",
    "Region",
    "Regions",
    "Rejected",
    "Restarted",
    "RobustBelief",
    "RobustEvent",
    "RobustFilter",
    "Rules",
    "SetMembershipFilter",
    "Source",
    "Step",
    "Stop",
    "Suspicion",
    "Team",
    "Truth",
    "Turned",
    "Unbounded",
    "Window",
    "follow",
    "watch",
    "wrap",
]
