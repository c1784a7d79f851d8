"""What measurements add to the team's polytope: the rows of all bearings, then those of all ranges."""

from collections.abc import Sequence

from filter.arrays import Array, Integers
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Kind, Sources
from filter.measurements import Bearing, Compass, Measurement, Range
from filter.sensing.rows import bearing_rows, on_robots, range_rows, spans_of_targets, world_arcs

KIND_OF: dict[type[Measurement], Kind] = {Compass: "compass", Bearing: "bearing", Range: "range"}

Numbered = Sequence[tuple[Measurement, Integers]]  # records with the numbers (k,) of their sources


def merged(polytope: Polytope, headings: AngularIntervals, numbered: Numbered, landmarks: Array, spacing: float) -> Polytope:
    """Return the team's polytope with the rows of bearings, and then of ranges, whose directions they narrow.

    The (n) headings are narrowed already, by the same measurements; landmarks are (l, 2) [m]; `spacing` is the greatest angle
    between two tangents of a range's far side [rad].
    """
    rows = []
    for record, source in numbered:
        if isinstance(record, Bearing):
            arcs = world_arcs(record, headings[record.robot])
            rows.append(bearing_rows(record.robot, record.target, arcs, source))
    polytope, rows = _with_rows(polytope, rows, landmarks), []
    for record, source in numbered:
        if isinstance(record, Range):
            arcs = spans_of_targets(polytope, landmarks, record.robot, record.target)
            rows.append(range_rows(record, arcs, source, spacing))
    return _with_rows(polytope, rows, landmarks)


def numbered_of(sources: Sources, measurements: Sequence[Measurement]) -> tuple[Sources, Numbered]:
    """Enter the records that make rows into the table; return it and each of these records with its (k,) numbers."""
    numbered: list[tuple[Measurement, Integers]] = []
    for record in measurements:
        if not isinstance(record, Compass):
            sources, numbers = sources.extended(KIND_OF[type(record)], record.time, record.robot, record.target)
            numbered.append((record, numbers))
    return sources, numbered


def _with_rows(polytope: Polytope, rows: list[Constraints], landmarks: Array) -> Polytope:
    more = [on_robots(each, polytope, landmarks) for each in rows]
    return polytope.with_constraints(Constraints.concatenate([polytope.constraints, *more])) if more else polytope
