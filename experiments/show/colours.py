"""One colour for each robot, the same in recordings and figures."""

from __future__ import annotations

from colorsys import hls_to_rgb

Colour = tuple[int, int, int]

# Okabe and Ito's palette, which people with any kind of colour vision can tell apart; without black, and without yellow,
# which nobody sees on white.
PALETTE: tuple[Colour, ...] = (
    (0, 114, 178),
    (213, 94, 0),
    (0, 158, 115),
    (204, 121, 167),
    (230, 159, 0),
    (86, 180, 233),
)
GOLDEN_TURN = 0.618033988749895  # of the circle of hues: neighbours in number are never neighbours in hue
LIGHTNESS = (0.36, 0.50, 0.62)


def colour_of(robot: int) -> Colour:
    """Return a robot's red, green and blue, 0 to 255: the palette's for the first ones, generated beyond."""
    if robot < len(PALETTE):
        return PALETTE[robot]
    beyond = robot - len(PALETTE)
    red, green, blue = hls_to_rgb(beyond * GOLDEN_TURN % 1, LIGHTNESS[beyond % len(LIGHTNESS)], 0.65)
    return round(255 * red), round(255 * green), round(255 * blue)


def mixed(colour: Colour, other: Colour, share: float) -> Colour:
    """Return a colour mixed with a share of another, from 0 (none of it) to 1."""
    red, green, blue = (round(one + share * (two - one)) for one, two in zip(colour, other, strict=True))
    return red, green, blue
