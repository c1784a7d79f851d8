"""The regions that a run shows, held against what is proved of each robot. Exact arithmetic, standard library only."""

from dataclasses import dataclass
from fractions import Fraction

from experiments.proof.edges import SIDES, Exact, across, plane, through_corner
from experiments.proof.exact import Vector, length
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


def checked_region(record: Record, edges: dict[Vector, Fraction]) -> Region:
    """Return a region that is the closed polygon of all that is proved of a robot, by offsets by normals.

    Raises:
        Broken: What is proved does not close, what is shown is smaller or larger, or its area or estimate is another's.
    """
    vertices = [plane(vertex) for vertex in record["vertices"]]
    hull, area, middle = hull_of(vertices), exact(record["area"]), plane(record["estimate"])
    box = [through_corner(edges, side) for side in BOX]
    if any(side is None for side in box):
        raise Broken("what is proved is no closed polygon")
    extents = max(abs(side) for side in box if side is not None), max(abs(part) for corner in hull for part in corner)
    off = TO + SHARE * min(extents)
    beyond = {normal: dot(normal, farthest(hull, normal)) - offset for normal, offset in edges.items()}
    if any(most > off * length(normal) for normal, most in beyond.items()):
        raise Broken("what is shown is larger than what is proved")
    touched = {normal: edges[normal] for normal, most in beyond.items() if most > -MANY * off}
    for normal in [*BOX, *outward(hull)]:
        most = dot(normal, farthest(hull, normal)) + off * length(normal)
        proved = through_corner(touched, normal, most)
        if proved is None or proved > most:
            proved = through_corner(edges, normal, most)
        if proved is None or proved > most:
            raise Broken("what is shown is smaller than what is proved")
        if dot(normal, middle) > most:
            raise Broken("the estimate is outside the region")
    exactly, extent = area_of(hull), max(length((x - hull[0][0], y - hull[0][1])) for x, y in hull)
    for told in (area, area_of(vertices)):  # or they are in another order
        if abs(told - exactly) > OF_AREA * exactly + off * (extent + off):
            raise Broken(f"an area of {float(told):.6g} m2 is shown of a polygon of {float(exactly):.6g} m2")
    return Region([(float(x), float(y)) for x, y in vertices], float(area), middle)


def outward(hull: list[Vector]) -> list[Vector]:
    """Return the outward normals of a hull's edges."""
    return [(b[1] - a[1], a[0] - b[0]) for a, b in zip(hull, [*hull[1:], hull[0]], strict=True) if a != b]


def hull_of(points: list[tuple[Exact, Exact]]) -> list[tuple[Exact, Exact]]:
    """Return the corners of the convex hull, counter-clockwise (Andrew, 1979).

    Raises:
        Broken: There is no point.
    """
    if not points:
        raise Broken("a region without a vertex")
    order: list[tuple[Exact, Exact]] = sorted(set(points))
    found = _half(order)[:-1] + _half(order[::-1])[:-1]
    return found or order


def _half(points: list[tuple[Exact, Exact]]) -> list[tuple[Exact, Exact]]:
    """Return those of points, in order, that lead round all others on one side."""
    half: list[tuple[Exact, Exact]] = []
    for point in points:
        while len(half) > 1 and turn(half[-2], half[-1], point) <= 0:
            half.pop()
        half.append(point)
    return half


def farthest(points: list[Vector], normal: Vector) -> Vector:
    """Return the point that is farthest in a direction."""
    return max(points, key=lambda point: dot(normal, point))


def turn(a: tuple[Exact, Exact], b: tuple[Exact, Exact], c: tuple[Exact, Exact]) -> Exact:
    """Return twice the area of a triangle, positive where it turns left."""
    return across((b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1]))


def area_of(points: list[Vector]) -> Fraction:
    """Return the area within a line through points and back, positive if it is counter-clockwise."""
    return sum((across(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)), Fraction(0)) / 2


def dot(a: Vector, b: Vector) -> Fraction:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1]
