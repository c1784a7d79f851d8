"""Corral: a dynamic set-membership filter for moving robot teams.

Everything that a user names is here: `from filter import SetMembershipFilter, Team`. What is not here may change without
notice.

Read in this order, rooms with a slash: errors, arrays, workers, compiled, geometry/, records/, team, joined, motions,
guarantee, linear/, sensing/, poses/, projection/, cameras/, sets/, diagnosis/, stream, follow, lag, ekf, watch, warm_up.
"""

from filter.arrays import Array, Floats, Integers, Mask
from filter.cameras.alignment import Alignment
from filter.diagnosis.robust_filter import RobustFilter
from filter.diagnosis.set_membership_filter import Policy, SetMembershipFilter
from filter.diagnosis.tolerance import Lies, SuspectClass, Tolerance
from filter.ekf import ExtendedKalmanFilter, GaussianBelief, NoiseModel
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder, OutOfRange
from filter.follow import AnyBelief, Filter, Step, changed, follow
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.north import heading_from_north, place_from_north
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.lag import FixedLag, Lagged, Mistimed
from filter.linear.sources import Source
from filter.motions import Motions
from filter.poses.cells import ByCases, Cases
from filter.projection.fallback import Fallback
from filter.projection.stop import Budget, Stop
from filter.projection.window import Window
from filter.records.differences import position_from_range_difference
from filter.records.frame import Frame, Truth
from filter.records.measurements import Bearing, Compass, Measurement, Position, Range
from filter.records.odometry import Odometry, Twist
from filter.records.presence import Left, Placed
from filter.records.relative import RelativeHeading
from filter.records.seen import seen_position
from filter.records.sensors import Sensor
from filter.sets.belief import Belief, Event
from filter.sets.merged import Directions
from filter.sets.proof import Evidence, Proof
from filter.sets.regions import Region, Regions
from filter.sets.set_membership import PHASES
from filter.sets.suspect import Confirmed, Doubted, Judged, Late, Passed, StartsOver, Suspect, Tolerated, Turned
from filter.stream import Arrival, frames_of
from filter.team import Team
from filter.warm_up import warm_up
from filter.watch import Alarm, watch

__all__ = ["Bearing", "Compass", "Frame", "Measurement", "Odometry", "Position", "Range", "Sensor", "Team"]
__all__ += ["RelativeHeading", "Truth", "Twist", "seen_position"]
__all__ += ["Arrival", "Left", "Motions", "Placed", "frames_of"]
__all__ += ["AngularIntervals", "Array", "Floats", "Integers", "Mask", "Polygon", "heading_from_north"]
__all__ += ["place_from_north", "position_from_range_difference", "wrap"]
__all__ += ["AnyBelief", "Filter", "FixedLag", "Lagged", "Mistimed", "Step", "changed", "follow"]
__all__ += ["warm_up", "watch"]
__all__ += ["PHASES", "Budget", "Lies", "Policy", "SetMembershipFilter", "Stop", "Window"]
__all__ += ["Alarm", "Belief", "ByCases", "Cases", "Directions", "Event", "Evidence", "Fallback", "Guarantee", "Proof"]
__all__ += ["Region", "Regions", "Source"]
__all__ += ["Confirmed", "Doubted", "Judged", "Passed", "StartsOver", "Suspect", "SuspectClass", "Tolerance", "Tolerated"]
__all__ += ["Alignment", "Late", "RobustFilter", "Turned"]
__all__ += ["ExtendedKalmanFilter", "GaussianBelief", "NoiseModel"]
__all__ += ["CorralError", "Inconsistent", "InvalidInput", "OutOfOrder", "OutOfRange"]
