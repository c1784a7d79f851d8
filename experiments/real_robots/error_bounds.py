"""What the errors of a run are like, sensor by sensor, and what bounds they suggest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from experiments.following.metrics import Value, rounded
from experiments.real_robots.bounds import Bounds, Knots
from experiments.real_robots.carried import CarriedBounds
from experiments.real_robots.errors import LENGTHS, Errors
from filter import Array, Team

QUANTILES = (0.5, 0.9, 0.99, 0.999)
BURST_GAP = 1.0  # broken measurements of a robot less apart than this are one burst [s]


def statistics(errors: Errors, team: Team) -> Iterator[dict[str, Value]]:
    """Yield what one kind's errors are like: of each robot, and of the team (robot "all")."""
    for robot in [*range(team.robots), None]:
        mine = errors.of(np.full(len(errors.robot), robot is None) | (errors.robot == robot))
        if len(mine.error):
            yield {"sensor": errors.kind, "robot": "all" if robot is None else team.name(robot), **_figures(mine)}


def _figures(errors: Errors) -> dict[str, Value]:
    size = np.abs(errors.error)
    span = float(np.ptp(errors.time))
    bursts = [len(burst) for robot in np.unique(errors.robot) for burst in _bursts(errors.of(errors.robot == robot))]
    moving = np.abs(errors.true) > np.finfo(float).tiny
    share = (errors.true + errors.error)[moving] / errors.true[moving]
    return {
        "count": len(size),
        "median": rounded(float(np.quantile(size, QUANTILES[0]))),
        **{f"q{100 * q:g}": rounded(float(np.quantile(size, q))) for q in QUANTILES[1:]},
        "largest": rounded(float(size.max())),
        "bias": rounded(float(np.median(errors.error))),
        "scale": rounded(float(np.median(share))) if errors.kind == "range" and len(share) else None,
        "broken": int(errors.broken.sum()),
        "broken_share": rounded(float(errors.broken.mean())),
        "broken_per_hour": rounded(3600 * float(errors.broken.sum()) / span) if span else None,
        "bursts": len(bursts),
        "longest_burst": max(bursts, default=0),
    }


def _bursts(errors: Errors) -> list[Array]:
    """Return the times of one robot's broken measurements, in bursts."""
    times = np.sort(errors.time[errors.broken])
    return [burst for burst in np.split(times, np.flatnonzero(np.diff(times) > BURST_GAP) + 1) if len(burst)]


def proposed(found: Sequence[Errors], bounds: Bounds, share: float, margin: float) -> Bounds:
    """Return bounds that a share of the run's errors at most would have broken, with a margin on those of motion.

    The proportion of the absolute and the relative bound of ranges stays as it is, and so does what the errors do not tell.
    """
    by_kind = {errors.kind: errors for errors in found}
    turning = bounds.range / bounds.relative_range if bounds.relative_range else np.inf  # [m]
    ranges, bearings = by_kind["range"], by_kind["bearing"]
    floor = np.maximum(ranges.true, turning) if np.isfinite(turning) else np.ones(len(ranges.true))
    relative = _outward(float(np.quantile(np.abs(ranges.error) / floor, 1 - share)), 0.01)
    absolute = relative * turning if np.isfinite(turning) else relative
    turn, distance, slip = (_knots(by_kind, kind, share, margin) for kind in ("turn", "path", "slip"))
    return replace(
        bounds,
        range=_outward(absolute, 0.01),
        relative_range=relative if np.isfinite(turning) else 0.0,
        bearing=_outward(float(np.quantile(np.abs(bearings.error), 1 - share)), 0.001),
        turn=turn,
        distance=distance,
        slip=slip,
    )


def _knots(by_kind: dict[str, Errors], kind: str, share: float, margin: float) -> Knots:
    """Return knots of the least concave function over the errors at each length, those that it needs."""
    points = [(0.0, 0.0)]
    for length in LENGTHS:
        size = np.abs(by_kind[f"{kind} over {length:g} s"].error)
        points.append((length, max(points[-1][1], _outward(margin * float(np.quantile(size, 1 - share)), 0.001))))
    hull: list[tuple[float, float]] = []
    for point in points:
        while len(hull) > 1 and _below(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    return tuple(hull[1:])


def _below(left: tuple[float, float], middle: tuple[float, float], right: tuple[float, float]) -> bool:
    return (middle[1] - left[1]) * (right[0] - left[0]) <= (right[1] - left[1]) * (middle[0] - left[0])


def _outward(value: float, step: float) -> float:
    return rounded(float(np.ceil(value / step - 1e-9)) * step)


def said(bounds: Bounds | CarriedBounds) -> str:
    """Return bounds as Python, in the form the filter takes them; angles in radians."""
    fields = ",\n".join(f"    {name}={value!r}" for name, value in vars(bounds).items())
    return f"{type(bounds).__name__}(\n{fields},\n)"
