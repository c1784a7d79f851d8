"""The regions that a run shows, held against what is proved of each robot. Exact arithmetic, standard library only."""

from dataclasses import dataclass
from fractions import Fraction

from experiments.proof.edges import SIDES, across, plane, through_corner
from experiments.proof.exact import KEPT, Vector, Whole, length, steps_long, whole
from experiments.proof.reading import Broken, Record, exact

# A region is shown to so many metres, and to this share of its coordinates; its area to this share.
TO, SHARE, OF_AREA = Fraction(1, 10**9), Fraction(1, 10**12), Fraction(1, 10**9)
MANY = 1000  # so many times that far from a region an edge does not matter
BOX = [plane(direction) for _, _, direction in SIDES]


@dataclass(frozen=True)
class Region:
    """One robot's region as it is shown.

    Attributes:
        vertices: Counter-clockwise [m].
        area: [m2].
        estimate: Its middle [m].
    """

    vertices: list[tuple[float, float]]
    area: float
    estimate: Vector


def region_of(record: Record) -> Region:
    """Return a region as a record shows it."""
    vertices = [(float(x), float(y)) for x, y in map(plane, record["vertices"])]
    return Region(vertices, float(exact(record["area"])), plane(record["estimate"]))


def checked_region(record: Record, edges: dict[Vector, Fraction]) -> Region:
    """Return a region that is the closed polygon of all that is proved of a robot, by offsets by normals.

    Raises:
        Broken: What is proved does not close, what is shown is smaller or larger, or its area or estimate is another's.
    """
    vertices = [plane(vertex) for vertex in record["vertices"]]
    *parts, unit_of = whole(*(part for vertex in vertices for part in vertex))
    points = list(zip(parts[::2], parts[1::2], strict=True))
    hull, area, middle = hull_of(points), exact(record["area"]), plane(record["estimate"])
    box = [edges[side] if side in edges else through_corner(edges, side) for side in BOX]
    if any(side is None for side in box):
        raise Broken("what is proved is no closed polygon")
    largest = Fraction(max(abs(part) for corner in hull for part in corner), unit_of)
    off = TO + SHARE * min(max(abs(side) for side in box if side is not None), largest)
    beyond = {normal: farthest(hull, unit_of, normal) - offset for normal, offset in edges.items()}
    if any(most > 0 and most > off * length(normal) for normal, most in beyond.items()):
        raise Broken("what is shown is larger than what is proved")
    touched = {normal: edges[normal] for normal, most in beyond.items() if most > -MANY * off}
    for normal in [*BOX, *((Fraction(x, unit_of), Fraction(y, unit_of)) for x, y in outward(hull))]:
        most = farthest(hull, unit_of, normal) + off * length(normal)
        proved = through_corner(touched, normal, most)
        if proved is None or proved > most:
            proved = through_corner(edges, normal, most)
        if proved is None or proved > most:
            raise Broken("what is shown is smaller than what is proved")
        if dot(normal, middle) > most:
            raise Broken("the estimate is outside the region")
    exactly, in_order = (Fraction(twice_area_of(each), 2 * unit_of**2) for each in (hull, points))
    extent = Fraction(max(steps_long((x - hull[0][0], y - hull[0][1])) for x, y in hull), unit_of << KEPT)
    for told in (area, in_order):
        if abs(told - exactly) > OF_AREA * exactly + off * (extent + off):
            raise Broken(f"an area of {float(told):.6g} m2 is shown of a polygon of {float(exactly):.6g} m2")
    return region_of(record)


def outward(hull: list[Whole]) -> list[Whole]:
    """Return the outward normals of a hull's edges."""
    return [(b[1] - a[1], a[0] - b[0]) for a, b in zip(hull, [*hull[1:], hull[0]], strict=True) if a != b]


def hull_of(points: list[Whole]) -> list[Whole]:
    """Return the corners of the convex hull, counter-clockwise (Andrew, 1979).

    Raises:
        Broken: There is no point.
    """
    if not points:
        raise Broken("a region without a vertex")
    order: list[Whole] = sorted(set(points))
    found = _half(order)[:-1] + _half(order[::-1])[:-1]
    return found or order


def _half(points: list[Whole]) -> list[Whole]:
    """Return those of points, in order, that lead round all others on one side."""
    half: list[Whole] = []
    for point in points:
        while len(half) > 1 and turn(half[-2], half[-1], point) <= 0:
            half.pop()
        half.append(point)
    return half


def farthest(points: list[Whole], unit_of: int, normal: Vector) -> Fraction:
    """Return the greatest normal . p of points in a unit."""
    x, y, scale = whole(*normal)
    return Fraction(max(x * p + y * q for p, q in points), scale * unit_of)


def turn(a: Whole, b: Whole, c: Whole) -> int:
    """Return twice the area of a triangle, positive where it turns left."""
    return across((b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1]))


def twice_area_of(points: list[Whole]) -> int:
    """Return twice the area within a line through points and back, positive if it is counter-clockwise."""
    return sum(across(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True))


def dot(a: Vector, b: Vector) -> Fraction:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1]
