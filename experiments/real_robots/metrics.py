"""What a run with real robots amounts to: the filter and the Kalman filter against the truth, at the same checks.

A check is one robot at one of the measurements that it made (two landmarks in one picture are two) for which there is
truth. Besides, every robot is looked at in every frame, whether it sees anything or not: `frame_` figures.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from experiments.following.ellipses import WIDE_SIZE, ellipse_areas, normalised_squares
from experiments.following.frozen import freeze
from experiments.following.metrics import Value, rounded
from experiments.real_robots.followed import Followed
from filter import Array, Bearing, Frame, GaussianBelief, Guarantee, Integers, Mask


@dataclass(frozen=True, eq=False)
class Table:
    """Everything that is judged, a row a frame (k), a column a robot (n).

    Attributes:
        time: (k,) [s].
        weight: (k, n) how many measurements the robot made in the frame.
        known: (k, n) whether there is truth.
        inside: (k, n) whether the truth is in the outer polygon; also where it is not known.
        turned: (k, n) whether the true heading is in its interval; also where it is not known.
        suspended: (k, n) whether the guarantee was suspended.
        rejected: (k, n) how many of the robot's measurements were rejected.
        area: (k, n) of the outer polygon [m2].
        error: (k, n) of its centroid, NaN where there is no truth [m].
        ekf_error: (k, n) of the Kalman filter's mean [m].
        ekf_area: (k, n) of its 99.7 % ellipse [m2].
        ekf_inside: (k, n) whether the truth is in it.
        seconds: (k,) how long the filter took.
    """

    time: Array
    weight: Integers
    known: Mask
    inside: Mask
    turned: Mask
    suspended: Mask
    rejected: Integers
    area: Array
    error: Array
    ekf_error: Array
    ekf_area: Array
    ekf_inside: Mask
    seconds: Array

    def __post_init__(self) -> None:
        freeze(self)


@dataclass
class Tally:
    """Collects a run, a frame at a time.

    Attributes:
        start: When the run starts [s].
        resets: How many robots were started over so far.
        put_aside: Which sensors were found wrong so far, and when.
        suspended: The guarantee as it was when it first was suspended for some robot; None for never.
    """

    start: float
    resets: int = 0
    put_aside: list[str] = field(default_factory=list)
    suspended: Guarantee | None = None
    _rows: list[dict[str, object]] = field(default_factory=list)

    def add(self, step: Followed, estimate: GaussianBelief) -> Escaped:
        """Take one frame in; return who is outside."""
        n = len(step.belief.regions)
        places, headings = _truth(step.frame, n)
        known = np.isfinite(places).all(axis=1) & np.isfinite(headings)
        outers = [region.outer for region in step.belief.regions]
        inside = np.array([bool(outer.contains(place)) for outer, place in zip(outers, places, strict=True)]) | ~known
        turned = step.belief.headings.contains(headings) | ~known
        centroids = np.array([outer.centroid for outer in outers])
        self.resets += step.resets
        if self.suspended is None and not step.guarantee.in_force.all():
            self.suspended = step.guarantee
        self.put_aside += [f"{name} at {step.frame.time - self.start:.1f} s" for name in step.put_aside]
        self._rows.append(
            {
                "time": step.frame.time,
                "weight": measured_by(step.frame, n),
                "known": known,
                "inside": inside,
                "turned": turned,
                "suspended": step.suspended,
                "rejected": np.bincount([source.robot for source in step.rejected], minlength=n),
                "area": [outer.area for outer in outers],
                "error": np.hypot(*(centroids - places).T),
                "seconds": step.seconds,
                **_estimated(estimate, places),
            }
        )
        return Escaped(~inside, ~turned, step.suspended)

    def table(self) -> Table:
        """Return all that was taken in."""
        return Table(**{name: np.array([row[name] for row in self._rows]) for name in self._rows[0]})


@dataclass(frozen=True, eq=False)
class Escaped:
    """Who is outside at one frame.

    Attributes:
        positions: (n,) the truth is outside the outer polygon.
        headings: (n,) the true heading is outside its interval.
        suspended: (n,) and whether the guarantee was suspended.
    """

    positions: Mask
    headings: Mask
    suspended: Mask


def _truth(frame: Frame, robots: int) -> tuple[Array, Array]:
    """Return true positions (n, 2) and headings (n,), NaN where nobody knows."""
    if frame.truth is None:
        return np.full((robots, 2), np.nan), np.full(robots, np.nan)
    return frame.truth.positions, frame.truth.headings


def _estimated(estimate: GaussianBelief, places: Array) -> dict[str, object]:
    """Return the Kalman filter's part of a row."""
    apart, covariances = estimate.mean[:, :2] - places, estimate.position_covariances
    return {
        "ekf_error": np.hypot(*apart.T),
        "ekf_area": ellipse_areas(covariances),
        "ekf_inside": normalised_squares(np.nan_to_num(apart), covariances) <= WIDE_SIZE,
    }


def measured_by(frame: Frame, robots: int) -> Integers:
    """Return (n,) how many things each robot measured in a frame: a bearing and a range of one target are one."""
    seen = [record.robot for record in frame.measurements if isinstance(record, Bearing)]
    return np.bincount(np.concatenate([np.zeros(0, dtype=np.int64), *seen]), minlength=robots)


def summary_of(table: Table, start: float, resets: int) -> dict[str, Value]:
    """Return the run's figures, flat, units in the names; None for what nothing is known of.

    Args:
        table: Of the run.
        start: When the run started [s].
        resets: How many robots were started over.
    """
    weight = np.where(table.known, table.weight, 0).astype(np.int64)
    out, turned_out = table.known & ~table.inside, table.known & ~table.turned
    lasted = np.diff(table.time, prepend=start)
    checks, frame_checks = int(weight.sum()), int(table.known.sum())
    escapes = int(weight[out].sum())
    spent = float(table.seconds.sum())
    return {
        "duration_s": rounded(float(lasted.sum())),
        "frames": len(table.time),
        "checks": checks,
        "escapes": escapes,
        "escape_share": _share(escapes, checks),
        "escapes_in_force": int(weight[out & ~table.suspended].sum()),
        "longest_escape_s": rounded(longest(table.time, table.known, out)),
        "suspended_share": _share(float((table.suspended * lasted[:, None]).sum()), float(lasted.sum()) * weight.shape[1]),
        "rejected": int(table.rejected.sum()),
        "resets": resets,
        "outer_area_median_m2": _quantile(np.repeat(table.area, weight.ravel()), 0.5),
        "outer_area_p95_m2": _quantile(np.repeat(table.area, weight.ravel()), 0.95),
        "set_rmse_m": _rmse(np.repeat(table.error, weight.ravel())),
        "ekf_rmse_m": _rmse(np.repeat(table.ekf_error, weight.ravel())),
        "ekf_containment_997": _share(float(weight[table.ekf_inside].sum()), checks),
        "ekf_area_997_median_m2": _quantile(np.repeat(table.ekf_area, weight.ravel()), 0.5),
        "heading_checks": checks,
        "heading_escapes": int(weight[turned_out].sum()),
        "heading_escapes_in_force": int(weight[turned_out & ~table.suspended].sum()),
        "frame_checks": frame_checks,
        "frame_escapes": int(out.sum()),
        "frame_escape_share": _share(int(out.sum()), frame_checks),
        "frame_escapes_in_force": int((out & ~table.suspended).sum()),
        "frame_heading_escapes_in_force": int((turned_out & ~table.suspended).sum()),
        "frame_outer_area_median_m2": _quantile(table.area.ravel(), 0.5),
        "frame_set_rmse_m": _rmse(table.error[table.known]),
        "frame_ekf_rmse_m": _rmse(table.ekf_error[table.known]),
        "step_median_ms": rounded(1e3 * float(np.median(table.seconds))),
        "real_time_factor": rounded(float(lasted.sum()) / spent) if spent > 0 else None,
    }


def longest(time: Array, known: Mask, out: Mask) -> float:
    """Return how long some robot was outside without a break [s].

    From the first frame outside to the first one inside. A gap of the truth, (k, n) not known, does not end an escape.
    """
    worst = 0.0
    for seen, outside in zip(known.T, out.T, strict=True):
        times = time[seen]
        edges = np.diff(np.concatenate([[0], outside[seen].astype(np.int64), [0]]))
        begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        lasting = times[np.minimum(ends, len(times) - 1)] - times[begins]
        worst = max(worst, float(lasting.max(initial=0.0)))
    return worst


def _share(part: float, whole: float) -> float | None:
    return rounded(part / whole) if whole else None


def _quantile(values: Array, share: float) -> float | None:
    return rounded(float(np.quantile(values, share))) if len(values) else None


def _rmse(errors: Array) -> float | None:
    return rounded(float(np.sqrt(np.mean(errors**2)))) if len(errors) else None
