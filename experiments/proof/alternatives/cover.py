"""What is said of all of several cases: arcs and edges that hold in each of them. Standard library only."""

from collections.abc import Sequence
from dataclasses import dataclass

from experiments.proof.chain import Chain, Placed
from experiments.proof.edges import WORLD, Edges, add, through_corner, unit_normal
from experiments.proof.exact import Arc, claimed
from experiments.proof.reading import Broken, Record, body, exact, located, shown


@dataclass(frozen=True)
class Cover:
    """What is said of the robots' headings, and edges around each of them."""

    headings: Sequence[Arc]
    shown: Edges


def covered(headings: Sequence[Placed], lines: Sequence[Placed], chains: Sequence[Chain], *, is_mine: bool) -> Cover:
    """Check that arcs are around those of several chains, and each edge is outside two edges of each; return these.

    Raises:
        Broken: An arc or an edge is not, where that is this process's to prove.
    """
    ((place, record),), edges, some = headings, Edges(), chains if is_mine else ()
    with located(place):
        arcs = [claimed(*each) for each in zip(record["centre"], record["bound"], strict=True)]
        for chain in some:
            if not all(arc.covers(one) for arc, one in zip(arcs, chain.headings, strict=True)):
                raise Broken("a heading of the cover is narrower than that of an alternative")
    for place, line in lines:
        with located(place):
            pair, normal, offset = _pair(line, len(arcs)), unit_normal(line["normal"]), exact(line["offset"])
            for chain in some:
                proved = chain.edges.get(pair, {}).get(normal)
                if proved is None or proved > offset:
                    proved = through_corner(chain.shown.get(pair, {}), normal, offset)
                if proved is None or proved > offset:
                    far = "no edges" if proved is None else f"edges {float(proved - offset):.3g} m farther out"
                    raise Broken(f"an edge of the cover, where an alternative has {far}")
            add(edges, pair, normal, offset)
    return Cover(arcs, edges)


def _pair(line: Record, robots: int) -> tuple[int, int]:
    """Return whose edge a line is about: that of a robot, or of two of so many."""
    i, j = line["from"], body(line["robot"], robots)
    if type(i) is not int or not WORLD <= i < j:
        raise Broken(f"a robot, or a pair of robots in order, was expected, not {shown(i)}, {j}")
    return i, j
