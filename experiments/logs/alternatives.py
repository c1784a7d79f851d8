"""What is proved in each case of a doubt, and why cases end: `alternatives.jsonl.gz` (see docs/soundness.md).

A record of an alternative has its name, that of its parent, what may be wrong in it, one of these, and the headings and lines
of each instant that it was taken through. Others say who is right again, which of them are united, who is put aside and is
not listened to, which robots start over, and which of these are in force again.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from experiments.logs.cases import slice_records
from experiments.logs.evidence import Records, of_evidence, proved
from experiments.logs.exactly import VERSION, hexadecimal
from filter import Array, Belief, Confirmed, Frame, Integers, InvalidInput, Measurement, StartsOver, Step, Suspect, Team
from filter.diagnosis.quiet import MEMORY
from filter.diagnosis.starting_over import waiting
from filter.diagnosis.suspects import everybody
from filter.diagnosis.told import in_one_order, without_all, without_robots, without_ties
from filter.geometry.polygon import SIDES
from filter.linear.constraints import WORLD
from filter.sets.belief import Alternatives as Cases
from filter.sets.belief import Diagnosis, Tried

PROVABLE = "certificates of a run"  # and what is wrong with it
NO_CASES = Cases(0.0, ())


class Alternatives:
    """Tells of each step what there is to prove in doubts, and in cases of who lies.

    Attributes:
        is_in_doubt: Whether the last step was in doubt, or was the end of a doubt; or there are cases of who lies.
    """

    def __init__(self, team: Team) -> None:
        self._team, self._recent, self.is_in_doubt = team, list[Frame](), False
        self._doubtful: Belief | None = None  # what was said in the last step, if that was in doubt

    def of(self, step: Step[Belief]) -> list[dict[str, Any]]:
        """Return the records of a step; raises `InvalidInput` where there are no certificates of it."""
        belief, before = step.belief, step.predicted
        known = belief.diagnosis or Diagnosis()
        if belief.guarantee.tolerating and (_has_doubted(known) or _restarts(step)):
            raise InvalidInput(f"{PROVABLE} in which nothing is in doubt where lies are tolerated", "a doubt")
        if belief.alternatives is not None:
            self.is_in_doubt = True
            return _of_cases(step, self._team.landmarks)
        if before.diagnosis and not all(one.parent for one in before.diagnosis.tried):
            raise InvalidInput(f"{PROVABLE} in which doubts begin with what is measured", "one that begins with a motion")
        self._recent = [*self._recent, Frame(step.frame.time, None, _heard(step, self._team.robots))][-MEMORY:]
        self.is_in_doubt = bool(known.tried)
        self._look_at(belief, known.tried)
        found = self._of_restarts(step) + [self._of_tried(one) for one in known.tried]
        united = [each for each in (*known.hypotheses, *([known.left] if known.left else [])) if each.unites]
        found += [{"name": each.name, "unites": list(each.unites), **_cover(each.belief)} for each in united]
        if known.left or belief.aside != before.aside:
            found.append({"aside": [list(suspect.who) for suspect in belief.aside]})
        confirmed = [event.robot for event in belief.events if isinstance(event, Confirmed)]
        self._doubtful = belief if known.hypotheses else None
        return found + ([{"confirmed": confirmed}] if confirmed else [])

    def _of_restarts(self, step: Step[Belief]) -> list[dict[str, Any]]:
        """Return which robots start over in a step, and in a doubt what was said before it, from which all others go on."""
        robots, unheard = {robot for event in _restarts(step) for robot in event.robots}, _unheard(step)
        if not robots:
            return []
        if np.isinf(self._team.arena).any():
            raise InvalidInput(f"{PROVABLE} in a closed arena, in which robots can be that start over", "an open one")
        if self._doubtful and step.frame.changes:
            raise InvalidInput(f"{PROVABLE} in which nobody comes or leaves as a doubt ends in robots that start over", "some")
        around = _cover(self._doubtful) if self._doubtful else {"headings": [], "lines": []}
        return [{"over": sorted(robots), "unheard": sorted(unheard), **around}]

    def _of_tried(self, one: Tried) -> dict[str, Any]:
        wrong = [list(suspect.who) for suspect in one.suspects]
        times = [*(belief.time for belief in one.beliefs), *([one.end[0]] if one.end else [])]
        evidence = [proved(belief, self._team.landmarks) for belief in one.beliefs]
        evidence += [of_evidence(*one.end, self._team.landmarks)] if one.end else []
        if one.is_again:
            headings, lines = evidence[0] if evidence else ([], [])
            return {"name": one.name, "again": one.parent, "wrong": wrong, "headings": headings, "lines": lines}
        anew = [*([list[int]()] * (len(times) - 1)), sorted(one.anew)]
        instants = [
            {"t": time.hex(), "anew": robots, "headings": headings, "lines": lines}
            for time, robots, (headings, lines) in zip(times, anew, evidence, strict=True)
        ]
        return {"name": one.name, "parent": one.parent, "wrong": wrong, "instants": instants}

    def _look_at(self, belief: Belief, tried: Sequence[Tried]) -> None:
        """Raise `InvalidInput` if something of a doubt cannot be proved, as yet."""
        born = [one for one in tried if not one.parent]
        if bad := next((one for one in tried if one.end and not one.end[1]), None):
            words = "; ".join(map(self._team.words, bad.suspects))
            raise InvalidInput(f"{PROVABLE} in which it is proved of each case why it cannot be", words)
        if np.isinf(self._team.arena).any() and any(one.anew or one.suspects[0].kind == "past" for one in tried):
            raise InvalidInput(f"{PROVABLE} in a closed arena, in which robots can be that are anywhere", "an open one")
        if missing := self._not_tried(belief, born):
            raise InvalidInput(f"{PROVABLE} in which each suspect was tried alone", "; ".join(missing))

    def _not_tried(self, belief: Belief, born: Sequence[Tried]) -> list[str]:
        """Return in words who can be wrong, too, when a doubt begins, but was not tried alone."""
        if not born:
            return []
        first = min([*(each.time for each in born[0].beliefs), *(one.end[0] for one in born if one.end)])
        frames = [frame for frame in self._recent if frame.time >= first]
        there = set(range(self._team.robots)) - belief.guarantee.away
        every = everybody(frames, there, self._team.robots, first)
        tried = {suspect.who for one in born for suspect in one.suspects}
        gone = {suspect.who for one in born if one.end for suspect in one.suspects}
        return [self._team.words(suspect) for suspect in every if not _is_known(suspect, tried, gone)]


def _is_known(suspect: Suspect, tried: set[tuple[str, int, int]], gone: set[tuple[str, int, int]]) -> bool:
    """Return whether a suspect was tried, or is a sighting by a sensor or of a body that cannot be wrong."""
    kind, robot, target = suspect.who
    return suspect.who in tried or (kind == "sighting" and bool(gone & {("sensor", robot, -1), ("body", -1, target)}))


def _restarts(step: Step[Belief]) -> list[StartsOver]:
    """Return that robots start over in a step, by its motion and by what was measured."""
    return [event for event in (*step.predicted.events, *step.belief.events) if isinstance(event, StartsOver)]


def _unheard(step: Step[Belief]) -> Collection[int]:
    """Return the robots of which nothing counts in a step that was measured, as they start over, or have."""
    before, now = step.predicted.diagnosis or Diagnosis(), step.belief.diagnosis or Diagnosis()
    if told := next((event for event in step.belief.events if isinstance(event, StartsOver)), None):
        return told.unheard
    return waiting(before) if before.hypotheses or now.tried else ()


def _heard(step: Step[Belief], robots: int) -> tuple[Measurement, ...]:
    """Return what counts in a step: without who is put aside, and without what ties robots that start over to others."""
    kept = without_all(step.predicted.aside, in_one_order(step.frame.time, step.frame.measurements))
    apart = waiting(step.predicted.diagnosis or Diagnosis()) | {robot for event in _restarts(step) for robot in event.robots}
    return without_robots(_unheard(step), without_ties(apart, robots, kept))


def _of_cases(step: Step[Belief], landmarks: Array) -> list[dict[str, Any]]:
    """Return what is proved in each case of who lies, and before that how those of the window before have become one."""
    known, before = step.belief.alternatives or NO_CASES, step.predicted.alternatives or NO_CASES
    if any(one.end and not one.end[1] for one in known.tried) or (not before.united and any(one.end for one in before.tried)):
        raise InvalidInput(f"{PROVABLE} in which no case of who lies ends by a motion, or without a proof", "one that does")
    if not known.tried:
        raise InvalidInput(f"{PROVABLE} that takes a step for each instant", "several at once")
    found = [_of_union(before, before.united, landmarks)] if before.united else []
    for one in known.tried:
        headings, lines = of_evidence(*one.end, landmarks) if one.end else proved(one.beliefs[0], landmarks)
        found.append({"lying": _who(one), "headings": headings, "lines": lines})
    return found


def _has_doubted(known: Diagnosis) -> bool:
    """Return whether something is in doubt, or has been."""
    return bool(known.hypotheses or known.aside or known.suspended or known.tried or known.left)


def _of_union(before: Cases, united: Belief, landmarks: Array) -> dict[str, Any]:
    """Return what cases say of pairs that become one, and what of all of them goes on."""
    pairs = [
        {"lying": _who(one), "lines": of_evidence(united.time, one.beliefs[0].proofs, landmarks)[1]} for one in before.tried
    ]
    if len(pairs) == 1:
        return {"united": pairs, "headings": [], "lines": [], "slices": []}
    robots = np.unique(united.slices.robot).tolist()
    slices = [{"robot": robot, "slices": slice_records(united.slices.of(robot))} for robot in robots]
    return {"united": pairs, **_cover(united), "slices": slices}


def _who(one: Tried) -> list[list[Any]]:
    return [list(suspect.who) for suspect in one.suspects]


def _cover(belief: Belief) -> dict[str, Any]:
    """Return what is known in all of some alternatives: rows, also on pairs, sides of boxes, arcs."""
    rows, (lower, upper) = belief.constraints, (belief.polytope.lower, belief.polytope.upper)
    robots, sides = np.arange(len(lower)), np.concatenate([upper, -lower], axis=1).ravel()
    boxes = _edges(belief.time, np.repeat(robots, len(SIDES)), np.tile(SIDES, (len(robots), 1)), sides)
    edges = _edges(belief.time, rows.j, rows.normal, rows.offset, rows.i)
    return {"headings": _arcs(belief), "lines": [*boxes, *edges]}


def said(belief: Belief) -> tuple[Records, Records]:
    """Return the arcs of headings and the edges of regions, which are proved in each case."""
    there = [robot for robot in range(len(belief.headings)) if robot not in belief.guarantee.away]
    edges = [(robot, belief.regions[robot].outer) for robot in there]
    lines = (_edges(belief.time, np.full(len(one.offsets), robot), one.normals, one.offsets) for robot, one in edges)
    return _arcs(belief), [line for some in lines for line in some]


def _arcs(belief: Belief) -> list[dict[str, Any]]:
    arcs = {"centre": hexadecimal(belief.headings.centre), "bound": hexadecimal(belief.headings.bound)}
    return [{"version": VERSION, "t": belief.time.hex(), **arcs, "lines": []}]


def _edges(
    time: float, robots: Integers, normals: Array, offsets: Array, seen_from: Integers | None = None
) -> list[dict[str, Any]]:
    """Return edges (k) of robots, or of pairs as seen from others, as lines without proofs of their own."""
    stamp, begin = {"version": VERSION, "t": time.hex()}, np.full(len(robots), WORLD) if seen_from is None else seen_from
    return [
        {**stamp, "robot": robot, "from": other, "normal": hexadecimal(normal), "offset": offset.hex()}
        for robot, other, normal, offset in zip(robots.tolist(), begin.tolist(), normals, offsets.tolist(), strict=True)
    ]
