"""Who a filter says is to blame: read from its belief here and nowhere else, and held against who is."""

from __future__ import annotations

from collections.abc import Iterable

from experiments.broken.fault import Fault

Culprit = tuple[str, tuple[int, ...]]  # of what kind, and which bodies


def named_by(belief: object) -> frozenset[Culprit]:
    """Return whom a belief has put aside; nobody, where a filter names nobody.

    Kinds are "past" (a robot's odometry or start), "compass" and "sensor" of a robot, "body" for whatever sees it, "sighting"
    of a robot that reads a target wrongly, "exchange" of two bodies.
    """
    aside: Iterable[object] = getattr(belief, "aside", ())
    return frozenset(_culprit(suspect) for suspect in aside)


def _culprit(suspect: object) -> Culprit:
    kind, robot, target = (getattr(suspect, name) for name in ("kind", "robot", "target"))
    if kind == "body":
        return kind, (target,)
    if kind == "sighting":
        return kind, (robot, target)
    if kind == "exchange":
        return kind, (min(robot, target), max(robot, target))
    return kind, (robot,)


def names_the_culprit(fault: Fault, named: frozenset[Culprit]) -> bool:
    """Return whether the culprit is named; two that are exchanged are so, too, if both of them are put aside."""
    both = {("body", (body,)) for body in (fault.robot, fault.body)}
    return fault.guilty in named or (fault.kind == "swap" and both <= named)


def innocents(fault: Fault, named: frozenset[Culprit]) -> frozenset[Culprit]:
    """Return who is named and is no part of what is wrong: single sightings of a lasting fault are a part of it."""
    return frozenset(each for each in named if each != fault.guilty and not _is_part(fault, each))


def _is_part(fault: Fault, culprit: Culprit) -> bool:
    kind, bodies = culprit
    if fault.kind == "swap":
        return kind in ("body", "sighting") and bodies[-1] in (fault.robot, fault.body)
    if fault.kind == "moved":
        return kind == "sighting" and bodies[-1] == fault.body
    return fault.kind == "biased" and kind == "sighting" and bodies[0] == fault.robot
