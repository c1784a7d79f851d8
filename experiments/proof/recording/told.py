"""What a run tells of its regions in numbers, the summary and the trajectories, held against the regions themselves.

Standard library only. The regions are those of `experiments.proof.shown`, which are proved.
"""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import sqrt
from pathlib import Path
from typing import Any

from experiments.proof.alternatives.cover import Cover
from experiments.proof.edges import WORLD
from experiments.proof.exact import Arc, unit
from experiments.proof.given.frame import Frame
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken, body, located, number, parsed, shown
from experiments.proof.shown import Region, dot

OF_NO_REGION = "on trust: numbers of the summary that are of no region"
SUSPENDED = "on trust: measurements that were rejected; the guarantee is suspended"
DIGITS = 5.01e-6  # means have six digits
TURNED = 1e-12  # to which headings are told in trajectories, as halves of angles [rad]


@dataclass
class Told:
    """Collects, a step at a time, what a summary and trajectories have to say.

    Attributes:
        log: What was given to the filter.
        poses: For each robot, the time, the estimate and the heading of each frame that it is there, as floats and an arc.
    """

    log: Log
    poses: list[list[tuple[float, float, float, Arc]]] = field(default_factory=list)
    _areas: list[float] = field(default_factory=list)
    _squares: list[Fraction] = field(default_factory=list)
    _escapes: int = 0
    _held: int = 0  # of these and of headings, those of robots for which the guarantee is in force
    _suspended: bool = False
    _looked: int = 0
    _turned: int = 0

    def add(self, frame: Frame, regions: Sequence[Region | None], cover: Cover, waiting: Collection[int]) -> None:
        """Take in one step's regions, None of those that are away, what is said, and who has started over, not in force."""
        self.poses = self.poses or [[] for _ in regions]
        self._suspended = self._suspended or bool(waiting)
        for robot, (region, heading) in enumerate(zip(regions, cover.headings, strict=True)):
            if region is None:
                continue
            x, y = map(float, region.estimate)
            self.poses[robot].append((frame.time, x, y, heading))
            self._areas.append(region.area)
            place, looks = frame.truth.get(robot, (None, None))
            if place is not None:
                off = (region.estimate[0] - place[0], region.estimate[1] - place[1])
                self._squares.append(dot(off, off))
                is_outside = any(dot(normal, place) > offset for normal, offset in cover.shown[WORLD, robot].items())
                self._escapes, self._held = self._escapes + is_outside, self._held + (is_outside and robot not in waiting)
            if looks is not None:
                is_outside = not heading.covers(Arc.between(looks, looks))
                self._turned, self._held = self._turned + is_outside, self._held + (is_outside and robot not in waiting)
                self._looked += 1

    def numbers(self) -> dict[str, Any]:
        """Return what a summary has to say."""
        frames, rate, checks, count = len(self.log.frames), self.log.rate, len(self._squares), len(self._areas)
        return {
            "robots": self.log.robots,
            "duration_s": frames / rate if rate else None,
            "rate_hz": rate,
            "checks": checks,
            "escapes": self._escapes,
            "heading_checks": self._looked,
            "heading_escapes": self._turned,
            "measurements": sum(frame.measurements for frame in self.log.frames),
            "outer_area_mean_m2": float(sum(map(Fraction, self._areas), Fraction(0)) / count) if count else None,
            "outer_area_p95_m2": _quantile(self._areas, 0.95) if count else None,
            "point_rmse_m": sqrt(sum(self._squares, Fraction(0)) / checks) if checks else None,
            "inconsistent": None,
        }

    def check_summary(self, path: Path) -> Counter[str]:
        """Check a summary; return how many of its numbers are as they have to be, and how many are on trust.

        Raises:
            Broken: A number is another, or is missing.
            OSError: There is no such file.
        """
        with located(path.name):
            told, needed = parsed(path.read_bytes()), self.numbers()
            for name, value in needed.items():
                if name not in told:
                    raise Broken(f"there is no {name}")
                if not _agree(told[name], value):
                    raise Broken(f"{name} is {shown(told[name])}, where {shown(value)} was expected")
            in_force, rejected = told["guarantee_in_force"] is True, body(told["rejected"], 2**53)
            if in_force and rejected:
                raise Broken("the guarantee is said to be in force, though something was rejected")
            if in_force and self._suspended:
                raise Broken("the guarantee is said to be in force, though robots have started over")
            escapes, known = told["escapes_in_force"], in_force or self._suspended
            if not (0 <= escapes <= self._held and (escapes == self._held or not known)):
                raise Broken(f"escapes_in_force is {shown(escapes)}, where {self._held} were outside")
            proved = len(needed) + 1
            aside = {OF_NO_REGION: len(told) - proved, SUSPENDED: rejected if known else max(1, rejected)}
            return Counter({"numbers of the summary": proved, **{name: count for name, count in aside.items() if count}})

    def check_trajectory(self, robot: int, path: Path) -> int:
        """Check the filter's trajectory of one robot; return how many poses it has.

        Raises:
            Broken: A pose is another, is missing or is too much.
            OSError: There is no such file.
        """
        with located(path.name):
            *lines, rest = path.read_bytes().decode().split("\n")
            if rest or len(lines) != len(self.poses[robot]):
                raise Broken(f"{len(lines)} whole lines, where there are {len(self.poses[robot])} frames with it")
        for place, (line, pose) in enumerate(zip(lines, self.poses[robot], strict=True), 1):
            with located(f"{path.name}, line {place}"):
                time, x, y, *flat, sine, cosine = (number(float(word)) for word in line.split())
                heading = unit((pose[3].low + pose[3].high) / 4)
                turned = max(abs(float(half[0]) - told) for half, told in zip(heading, (cosine, sine), strict=True))
                if (time, x, y) != pose[:3] or turned > TURNED or flat != [0.0, 0.0, 0.0]:
                    raise Broken(f"another pose than the region's, at ({pose[1]}, {pose[2]}) at t = {pose[0]} s")
        return len(lines)


def _agree(told: Any, value: Any) -> bool:
    """Return whether a number of a summary is the right one; means are rounded there."""
    if isinstance(value, float) and type(told) in (int, float):
        return abs(told - value) <= DIGITS * abs(value)
    return type(told) is type(value) and told == value


def _quantile(values: list[float], share: float) -> float:
    """Return a quantile, between two values in proportion."""
    order, at = sorted(values), share * (len(values) - 1)
    below = int(at)
    above = min(below + 1, len(order) - 1)
    return order[below] + (at - below) * (order[above] - order[below])
