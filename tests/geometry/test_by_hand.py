"""Polygons made by hand: what is open, empty or crooked is refused; what the library makes can be made again."""

import numpy as np
import pytest
from helpers.worlds import World

from filter import InvalidInput, Polygon, RobustFilter, SetMembershipFilter

NORMALS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
OFFSETS = np.ones(4)
VERTICES = np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
STAR = np.array([0.0, 2.4, 1.2, 3.6, 4.9])  # it goes round once in all, with a step back

CROOKED = {
    "nothing": (np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2))),
    "a half-plane": (NORMALS[:1], OFFSETS[:1], VERTICES[:1]),
    "a strip": (NORMALS[::2], OFFSETS[::2], [[1.0, 0.0], [-1.0, 0.0]]),
    "a line": ([[1.0, 0.0], [-1.0, -0.0]], np.zeros(2), [[0.0, 0.0], [0.0, 1.0]]),
    "open on one side": (NORMALS[:3], OFFSETS[:3], VERTICES[:3]),
    "an empty set": (NORMALS, [-2.0, 1.0, -2.0, 1.0], VERTICES),
    "vertices elsewhere": (NORMALS, OFFSETS, VERTICES + 0.01),
    "vertices inside": (NORMALS, OFFSETS, VERTICES * 0.99),
    "vertices outside": (NORMALS, OFFSETS, VERTICES * 1.01),
    "a margin that excuses little": (NORMALS, OFFSETS, VERTICES * 1.01, 0.001),
    "long normals": (2 * NORMALS, 2 * OFFSETS, VERTICES),
    "clockwise": (NORMALS[::-1], OFFSETS, VERTICES[::-1]),
    "twice round": (np.tile(NORMALS, (2, 1)), np.ones(8), np.tile(VERTICES, (2, 1))),
    "not convex": (np.stack([np.cos(STAR), np.sin(STAR)], 1), np.ones(5), np.zeros((5, 2))),
}


@pytest.mark.parametrize("name", CROOKED)
def test_what_bounds_no_set_is_refused(name):
    with pytest.raises(InvalidInput, match=r"each vertex where an edge ends .* came \d edges"):
        Polygon(*CROOKED[name])


@pytest.mark.parametrize(
    ("part", "wrong"),
    [(0, NORMALS[:3]), (1, OFFSETS[:3]), (2, VERTICES[:3]), (0, np.eye(4)), (1, np.ones((4, 1))), (2, VERTICES.ravel())],
)
def test_parts_of_unlike_shapes_are_refused(part, wrong):
    parts = [NORMALS, OFFSETS, VERTICES]
    parts[part] = wrong
    with pytest.raises(InvalidInput, match=r"a normal \(2,\), an offset and a vertex \(2,\) for each edge"):
        Polygon(*parts)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -0.1, "0", None, [0.0]])
def test_a_margin_that_is_none_is_refused(wrong):
    with pytest.raises(InvalidInput, match="margin"):
        Polygon(NORMALS, OFFSETS, VERTICES, wrong)


@pytest.mark.parametrize("part", range(3))
@pytest.mark.parametrize("wrong", [np.nan, np.inf, "text", None])
def test_parts_that_are_not_finite_are_refused(part, wrong):
    parts = [array.astype(object) for array in (NORMALS, OFFSETS, VERTICES)]
    parts[part][1] = wrong
    with pytest.raises(InvalidInput, match="finite numbers"):
        Polygon(*parts)


def test_a_square_of_lists_is_a_square():
    square = Polygon(NORMALS.astype(int).tolist(), [1, 1, 1, 1], VERTICES.tolist(), 0)
    assert square.area == 4.0
    assert square.contains([1, 1]) and not square.contains([1.1, 1])


def made(rng):
    """Yield polygons as the library makes them: far and near, thin, points and segments, between lines all but parallel."""
    centre, size = rng.normal(size=2) * 10.0 ** rng.uniform(-3, 6), 10.0 ** rng.uniform(-6, 6)
    points = centre + rng.normal(size=(rng.integers(1, 12), 2)) * size * 10.0 ** rng.uniform(-9, 0, 2)
    yield from (Polygon.from_vertices(points), Polygon.hull(points), Polygon.box(points.min(0), points.max(0)))
    angles = np.repeat(rng.uniform(-np.pi, np.pi, 5), 2) + np.tile([0, np.pi], 5)
    angles += rng.normal(size=10) * 10.0 ** rng.uniform(-16, -1)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    offsets = normals @ points[0] + rng.random(10) * size * 10.0 ** rng.uniform(-16, 0)
    cut = Polygon.from_half_planes(normals, offsets, centre - 100 * size, centre + 100 * size)
    yield cut
    yield cut.intersection(Polygon.box(points[0] - size, points[0] + 1e-12 * size))


@pytest.mark.parametrize("seed", range(200))
def test_what_the_library_makes_can_be_made_by_hand(seed):
    for polygon in made(np.random.default_rng(seed)):
        again = Polygon(polygon.normals, polygon.offsets, polygon.vertices, polygon.margin)
        assert again.vertices.tobytes() == polygon.vertices.tobytes()


@pytest.mark.parametrize("kind", [SetMembershipFilter, RobustFilter])
@pytest.mark.parametrize("seed", range(3))
def test_regions_can_be_made_by_hand_and_started_from(kind, seed):
    world = World(np.random.default_rng(seed), robots=3, landmarks=2, errors="extreme", origin=np.array([1e4, -3e5]))
    own = kind(world.team)
    belief = own.update(own.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    outers = [region.outer for region in belief.regions]
    again = [Polygon(outer.normals, outer.offsets, outer.vertices, outer.margin) for outer in outers]
    started = own.start(1.0, again, belief.headings)
    assert all(region.outer.contains(place) for region, place in zip(started.regions, world.positions, strict=True))
