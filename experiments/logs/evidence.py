"""What an update has proved, as certificates: headings, each with what has to be proved before it, and lines."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from experiments.logs.cases import case_record
from experiments.logs.exactly import VERSION, hexadecimal, row_record, source_record
from experiments.logs.sides import Sighted, Sights, boxes_at_a_glance, sides_of_bearings, sides_of_ranges
from experiments.logs.votes import vote_records
from filter import AngularIntervals, Array, Belief, ByCases, Cases, Directions, Evidence, Integers, Proof
from filter.linear.sources import Sources
from filter.poses.votes import Polled

Part = Proof | Sighted | ByCases | Polled | AngularIntervals | Directions
Records = Sequence[dict[str, Any]]


def proved(belief: Belief, landmarks: Array) -> tuple[Records, Records]:
    """Return the headings of a belief, as often as they became narrower, and its lines; landmarks are (l, 2) [m]."""
    used = ranges_at(belief.time, belief.sources, belief.constraints.source)
    return of_evidence(belief.time, belief.proofs, landmarks, used)


def of_evidence(time: float, proofs: Sequence[Evidence], landmarks: Array, used: Sights = ()) -> tuple[Records, Records]:
    """Return the same of proofs of a time [s]; of ranges those sides are there that something rests on, used or proved."""
    stamp = {"version": VERSION, "t": time.hex()}
    headings, lines, cases = list[dict[str, Any]](), list[dict[str, Any]](), dict[int, ByCases]()
    readings = next((each.readings for each in proofs if isinstance(each, Directions)), None)
    for part in _parts(time, proofs, landmarks, set(used)):
        if isinstance(part, AngularIntervals | Directions):
            headings.append({**stamp, **_looks(part), "lines": lines})
            lines, cases = [], {}
        elif isinstance(part, Polled):
            lines += [{**stamp, **record} for record in vote_records(part)]
        elif isinstance(part, ByCases) and readings is not None:
            lines.append({**stamp, **case_record(part, readings, cases)})
            cases[part.robot] = part
        elif isinstance(part, Proof | Sighted):
            found = records(part) if isinstance(part, Proof) else side_records(part)
            lines += [{**stamp, **line} for line in found]
    return headings, lines


def _looks(part: AngularIntervals | Directions) -> dict[str, Any]:
    """Return what headings are, or that nothing is left of one."""
    if isinstance(part, Directions):
        return {"empty": True}
    return {"centre": hexadecimal(part.centre), "bound": hexadecimal(part.bound)}


def _parts(time: float, proofs: Sequence[Evidence], landmarks: Array, used: set[tuple[int, int | None]]) -> list[Part]:
    """Return all that has to be proved, in order; headings are proved from what is before them."""
    parts = list[Part]()
    for before, each in reversed(list(pairwise((None, *proofs)))):
        now = _read(each, before, landmarks, used) if isinstance(each, Directions) else _found(each, before)
        parts = now + parts
        for proof in (part.proof if isinstance(part, Sighted) else part for part in now):
            if isinstance(proof, Proof):
                used |= ranges_at(time, proof.sources, proof.polytope.constraints.source[proof.weights.row])
    return parts


def _read(read: Directions, before: Evidence | None, landmarks: Array, used: Sights) -> list[Part]:
    """Return what a pass has read, if another one was before it, from the boxes that one left."""
    boxes: list[Part] = [boxes_at_a_glance(read, before)] if isinstance(before, Directions) else []
    sides = sides_of_bearings(read, landmarks)
    if read.is_torn:
        return [*boxes, sides, read]
    return [*boxes, sides, read.headings, sides_of_ranges(read, landmarks, used)]


def _found(each: Proof | Cases | Polled | None, before: Evidence | None) -> list[Part]:
    """Return a proof, or votes, or all cases, after the headings that they began with if others were found before in cells."""
    if isinstance(each, Cases):
        return [*([each.told.headings] if isinstance(before, Cases) else []), *each]
    if isinstance(each, Polled):
        return [each, each.headings]
    return [each] if each else []


def records(proof: Proof) -> list[dict[str, Any]]:
    """Return the certificate of every claim of a proof."""
    rows = proof.polytope.constraints
    of_rows = {row: row_record(rows, row) for row in set(proof.weights.row.tolist())}
    lower, upper = proof.polytope.lower, proof.polytope.upper
    found = []
    for claim, (robot, seen_from) in enumerate(zip(proof.j.tolist(), proof.i.tolist(), strict=True)):
        used, multipliers = proof.rests_on(claim)
        numbers = used.tolist()
        bodies = sorted({robot, seen_from, *rows.i[used].tolist(), *rows.j[used].tolist()} - {-1})
        found.append(
            {
                "robot": robot,
                "from": seen_from,
                "normal": hexadecimal(proof.normal[claim]),
                "offset": float(proof.offset[claim]).hex(),
                "rows": [of_rows[k] | {"multiplier": y.hex()} for k, y in zip(numbers, multipliers.tolist(), strict=True)],
                "lower": {str(body): hexadecimal(lower[body]) for body in bodies},
                "upper": {str(body): hexadecimal(upper[body]) for body in bodies},
                "sources": [source_record(proof.sources[int(rows.source[k])]) for k in numbers],
                **({"empty": True} if proof.of == "nothing" else {}),
            }
        )
    return found


def side_records(sides: Sighted) -> list[dict[str, Any]]:
    """Return the certificates of sides, each with the target that it is about, and the sensors if they are mounted."""
    found = [{**line, "side": target} for line, target in zip(records(sides.proof), sides.about.tolist(), strict=True)]
    if sides.sensors is None:
        return found
    return [{**line, "sensors": pair} for line, pair in zip(found, sides.sensors.tolist(), strict=True)]


def ranges_at(time: float, sources: Sources, numbers: Integers) -> set[tuple[int, int | None]]:
    """Return robot and target of each range of a time among some sources."""
    named = map(sources.__getitem__, np.unique(numbers).tolist())
    return {(one.robot, one.target) for one in named if one.kind == "range" and one.time == time}
