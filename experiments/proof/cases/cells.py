"""What was found case by case, cut anew: the pieces of a tree of a robot's poses. Exact arithmetic, standard library only.

A piece is a polygon of places and an arc of headings. All that was measured of the robot cuts it, target after target, as often
as the line says; then it is split in two, or else it has to be within everything that is claimed, unless nothing is left of it.
Targets are landmarks, and polygons of places of mates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, pi

from experiments.proof.arms import Two, around
from experiments.proof.cases.cone import HAIR, directions, towards
from experiments.proof.cases.polygon import Polygon, Three, three
from experiments.proof.cases.slices import Slice, are_around, slices_in
from experiments.proof.edges import WORLD, plane, unit_normal
from experiments.proof.exact import (
    ANGLES,
    ANYWHERE,
    CHOSEN,
    HALF,
    KEPT,
    Arc,
    Whole,
    above,
    are_apart,
    below,
    claimed,
    in_common,
    once_around,
    steps,
    steps_long,
)
from experiments.proof.given.frame import Reading, Who
from experiments.proof.measured import Instant, between
from experiments.proof.reading import Broken, Record, exact, shown
from experiments.proof.sides import looking

# No piece is cut more often, tangents are no nearer to one another [rad], and there are no more cuts in all.
ROUNDS, LEAST_SPACING, CUTS = 10, 0.01, 2_000_000
# As the filter widens everything, and counts tangents: which half-planes cut a piece depends on what those before have left.
WIDENING, FEWER = Fraction(1, 10**8), 1e-5
WIDER, STEPS, TWICE = above(WIDENING), 1 << ANGLES, 2 << ANGLES
TURNS_ROUNDING = Fraction(1, 10**30)  # some turns on, an arc is wider by less [rad]
Pose = tuple[Polygon, Arc]
Said = Mapping[Who, Sequence[Reading]]
Spots = tuple[int, int]  # on the body with the lower number, and on the other


@dataclass(frozen=True)
class Bearing:
    """A bearing: by the robot itself, or a direction in the world that a mate's bearing leaves."""

    value: Fraction
    bound: Fraction
    way: Arc | None = None


@dataclass(frozen=True)
class Range:
    """A range: the least and the greatest distance [m]."""

    least: Fraction
    greatest: Fraction


@dataclass(frozen=True)
class Target:
    """Where a target is, what is measured of it and the robot, and how near it can be at least, in steps of 2^-110 m."""

    places: Polygon
    readings: Sequence[Bearing | Range]
    nearest: int


def check_cases(line: Record, then: Instant, roots: Sequence[Slice]) -> Arc | None:
    """Return what is proved of the robot's heading, if the line's claims hold in every case; None if no case is left.

    Its boxes and rows, and the roots, slices that its cases begin from, if any, have to be proved before. Of what was measured,
    that counts which is `said` in the line.

    Raises:
        Broken: A piece is not within what is claimed, or the line is misshapen.
    """
    then = replace(then, headings=looking(then.frame, then.headings))
    robot, claim = line["robot"], claimed(*line["heading"])
    claims = [three(*unit_normal(claim["normal"]), exact(claim["offset"])) for claim in line["claims"]]
    places, spacing = places_in(line), float(exact(line["spacing"]))
    said = {who: then.frame.of(*who) for who in ((one["kind"], one["robot"], one["target"]) for one in line["said"])}
    _bound_work(line, spacing, sum(map(len, said.values())))
    bodies = sorted({body for _, *two in said for body in two} - {robot})
    targets = [target for body in bodies for target in _targets(then, robot, body, places, said)]
    arcs, slices = list[Arc](), slices_in(line, "slices")
    waiting = list(reversed(_poses(roots, places[robot], then.headings[robot])))
    for piece in line["pieces"]:
        pose = waiting.pop()
        if pose and (claims or slices) and claim.covers(pose[1]) and not _beyond(pose, claims, slices):
            arcs.append(pose[1])
            pose = None  # what is claimed holds already, whatever cuts and parts leave
        for _ in range(piece["rounds"]):
            for target in targets:
                pose = _seen(pose, target, spacing) if pose else None
        if "line" in piece:
            waiting += reversed(_split(pose, *map(exact, piece["line"])))
        elif pose:
            arcs.append(pose[1])
            if what := _beyond(pose, claims, slices):
                raise Broken(f"in one of the cases robot {robot} can be beyond {what}")
    if waiting:
        raise Broken("there are pieces that no case is about")
    if not arcs:
        return None
    for heading in (claim, claim.widened(Fraction(0), TURNS_ROUNDING)):
        if all(heading.covers(arc) for arc in arcs):
            return heading
    raise Broken(f"in one of the cases robot {robot} can look elsewhere than what is claimed")


def _beyond(pose: Pose, claims: Sequence[Three], slices: Sequence[Slice]) -> str:
    """Return in words beyond what a pose can be, of all that is claimed; nothing if it is within."""
    if not all(pose[0].is_behind(claim) for claim in claims):
        return "what is claimed"
    return "its slices" if slices and not are_around(slices, *pose) else ""


def _poses(slices: Sequence[Slice], polygon: Polygon, heading: Arc) -> list[Pose | None]:
    """Return the poses that cases begin from: all that a polygon and a heading leave of slices, or both as they are."""
    if not slices:
        return [(polygon, once_around(heading))]
    found = list[Pose | None]()
    for each in slices:
        places = None if are_apart(each.arc, heading) else each.cut(polygon)
        found.append((places, once_around(in_common(each.arc, [heading]))) if places else None)
    return found


def _bound_work(line: Record, spacing: float, readings: int) -> None:
    """Raise `Broken` where it would take for ever: pieces may be cut so often, by each reading, and by each of its tangents."""
    rounds = [piece["rounds"] for piece in line["pieces"]]
    if not all(type(count) is int and 0 <= count <= ROUNDS for count in rounds):
        raise Broken(f"rounds from 0 to {ROUNDS} were expected, not {shown(rounds)}")
    if not spacing >= LEAST_SPACING or sum(rounds) * readings * (1 + 2 * pi / spacing) > CUTS:
        raise Broken(f"{sum(rounds)} rounds of {readings} readings, with tangents {spacing:g} rad apart, are too many")


def places_in(line: Record) -> dict[int, Polygon]:
    """Return where the robots of a line can be, by its boxes and rows."""
    found = {int(text): Polygon.box(plane(line["lower"][text]), plane(line["upper"][text])) for text in line["upper"]}
    for row in line["rows"]:
        if row["i"] != WORLD:
            raise Broken("a row on a pair, where rows on one robot were expected")
        cut = found[row["j"]].cut(three(*plane(row["normal"]), exact(row["offset"])))
        if cut is None:
            raise Broken(f"robot {row['j']} is nowhere")
        found[row["j"]] = cut
    return found


def _targets(then: Instant, robot: int, body: int, places: Mapping[int, Polygon], said: Said) -> list[Target]:
    """Return a body as targets of a robot, one for each two places that something was measured between.

    Bearings come before ranges, and the robot's own before its mate's.
    """
    found: dict[Spots, tuple[Two, list[Bearing | Range]]] = {}
    for kind, who, whom in (("bearing", robot, body), ("bearing", body, robot), ("range", robot, body), ("range", body, robot)):
        for one in sorted(said.get((kind, who, whom), ()), key=lambda one: _as_measured(kind, one)):
            mounts = (one.own, one.other) if who == robot else (one.other, one.own)
            spots = (mounts[0].spot, mounts[1].spot) if robot < body else (mounts[1].spot, mounts[0].spot)
            found.setdefault(spots, (mounts, []))[1].append(_said_of(then, one, who if who != robot else None, kind))
    return [_target(then, (robot, body), places, *found[spots]) for spots in sorted(found)]


def _as_measured(kind: str, one: Reading) -> tuple[Fraction, Fraction]:
    """Return value and bound as the sensor said them, which they are sorted by."""
    turned = kind == "bearing"
    return one.value - turned * one.own.angle, one.bound - turned * one.own.angle_off


def _said_of(then: Instant, one: Reading, mate: int | None, kind: str) -> Bearing | Range:
    if kind == "range":
        least, greatest = between(one)
        return Range(least * (1 - WIDENING), greatest * (1 + WIDENING))
    bound = one.bound + WIDENING
    way = None if mate is None else then.headings[mate].widened(one.value, bound).opposite
    return Bearing(one.value, bound, way)


def _target(
    then: Instant, who: tuple[int, int], places: Mapping[int, Polygon], mounts: Two, readings: Sequence[Bearing | Range]
) -> Target:
    """Return where a target is, as a robot's centre would see it if its sensor saw what it sees."""
    body, robots = who[1], then.log.robots
    where = places[body] if body < robots else Polygon.around([then.log.landmarks[body - robots]])
    if not (mounts[0].is_at_the_centre and mounts[1].is_at_the_centre):
        looks = {each: then.headings[each] for each in who if each < robots}
        where = Polygon.around(around(where.corners, mounts, who, looks))
    nearest = max((below(one.least, KEPT) for one in readings if isinstance(one, Range)), default=0)
    return Target(where, readings, nearest)


def _split(pose: Pose | None, x: Fraction, y: Fraction, offset: Fraction) -> list[Pose | None]:
    """Return both sides of a line of places, or of an angle of headings if the line has no direction."""
    if pose is None:
        return [None, None]
    polygon, arc = pose
    if x == y == 0:
        at = below(offset)
        at += 2 * HALF * ((arc.first + arc.last - 2 * at + 2 * HALF) // (4 * HALF))
        at = min(max(at, arc.first), arc.last)
        return [(polygon, Arc(arc.first, at)), (polygon, Arc(at, arc.last))]
    sides = polygon.cut(three(x, y, offset)), polygon.cut(three(-x, -y, -offset))
    return [(side, arc) if side else None for side in sides]


def _seen(pose: Pose, target: Target, spacing: float) -> Pose | None:
    """Return what the readings of one target leave of a pose, or None."""
    polygon: Polygon | None
    (polygon, heading), places, nearest = pose, target.places, target.nearest
    arc = directions(polygon, places, nearest)
    apart = arc is not ANYWHERE or nearest > 0  # of what is in one place with the robot, bearings say nothing
    for reading in target.readings:
        if polygon is None:
            return None
        if isinstance(reading, Range):
            polygon = _within(polygon, places, arc, reading, spacing)
            continue
        way = reading.way
        if way is None:
            looks = arc.widened(-reading.value, reading.bound)
            if apart and are_apart(heading, looks):
                return None
            heading = in_common(heading, [looks]) if apart else heading
            way = heading.widened(reading.value, reading.bound)
        for normal in _sides(way):
            polygon = polygon and _behind(polygon, places, normal, 0)
        if apart and are_apart(arc, way):
            return None
        arc = in_common(arc, [way])
    return (polygon, heading) if polygon else None


def _within(polygon: Polygon, places: Polygon, arc: Arc, reading: Range, spacing: float) -> Polygon | None:
    """Return the places that a range leaves, with the target in an arc of directions."""
    left: Polygon | None = polygon
    arc = Arc(arc.first - WIDER, arc.last + WIDER)
    centre, bound = (arc.first + arc.last) / TWICE, min(arc.width / TWICE, pi)
    if polygon.is_nearer(places, reading.least):
        return None
    tangents, far = max(1, ceil(2 * bound / spacing - FEWER)), steps(reading.greatest)
    for k in range(tangents):
        normal = towards(centre + bound * ((2 * k + 1) / tangents - 1))
        left = left and _behind(left, places, normal, _times(far, steps_long(normal)))
    back = towards(centre + pi)
    if arc.narrow and (slope := arc.steepest(back)) <= 0:
        left = left and _behind(left, places, back, _times(below(reading.least, KEPT), slope))
    return left


def _times(distance: int, slope: int) -> int:
    """Return a product in steps of 2^-110, rounded up, of a distance in the same and a slope in these of 2^-60."""
    return -(-distance * slope >> KEPT + CHOSEN)


def _behind(polygon: Polygon, places: Polygon, normal: Whole, offset: int) -> Polygon | None:
    """Return the places from which some place q of a target has normal . (q - p) <= offset, in steps of 2^-60 and 2^-110."""
    x, y = -normal[0], -normal[1]
    return polygon.cut((x << KEPT - CHOSEN, y << KEPT - CHOSEN, offset + places.reach((x, y))))


def _sides(arc: Arc) -> list[Whole]:
    """Return normals that no direction of an arc is beyond, one at each of its ends; none if it is no convex set."""
    if not arc.narrow:
        return []
    normals = towards(arc.first / STEPS - HAIR - pi / 2), towards(arc.last / STEPS + HAIR + pi / 2)
    return [normal for normal in normals if arc.steepest(normal) <= 0]
