"""One size of team: the filter in windows follows it, and is held against the whole team and against the Kalman filter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from experiments.against_ekf.tuning import TUNED
from experiments.following.metrics import Metrics, rounded
from experiments.following.scenarios import Scenario
from experiments.following.steps import steps, warmed_up
from experiments.growth.size import LEFT_OUT, Case, Size
from experiments.sweep.own_process import peak_memory_mib
from filter import PHASES, Belief, ExtendedKalmanFilter, Frame, Inconsistent, SetMembershipFilter, Step, Window
from filter.linear.constraints import WORLD
from filter.projection.window import links, members_of
from sim.errors import ErrorKind

COMPARED_EVERY = 10  # steps
TEAM_UP_TO = 100  # robots that the whole team's linear program is solved for
EKF_UP_TO = 1000  # robots: its covariance has nine numbers for each pair
EKF_STEPS = 10
EKF_PATIENCE = 60.0  # after this it starts no further step [s]


@dataclass
class Tally:
    """Collects what a size comes to, a step at a time."""

    window: Window
    phases: Phases
    checked: Metrics = field(default_factory=Metrics)
    seconds: list[float] = field(default_factory=list)
    by_phase: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in PHASES})
    areas: list[float] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    windows: list[int] = field(default_factory=list)
    compared: list[Step[Belief]] = field(default_factory=list)

    def add(self, step: Step[Belief]) -> None:
        """Take one step in."""
        by_phase = self.phases.taken()
        self.checked.add(step.frame, step.belief, step.seconds)
        if self.checked.steps <= LEFT_OUT:
            return
        self.seconds.append(step.seconds)
        for name, seconds in by_phase.items():
            self.by_phase[name].append(seconds)
        self.rows.append(len(step.belief.constraints))
        self.areas.append(mean_area(step.belief))
        if len(self.seconds) % COMPARED_EVERY == 1:
            self.windows += window_sizes(step.belief, self.window)
            self.compared.append(step)


class Phases:
    """Takes the time of each phase of the filter's step; the last one ends when `taken` is called."""

    def __init__(self) -> None:
        self._begun: list[tuple[str, float]] = []

    def __call__(self, name: str) -> None:
        """Let a phase begin."""
        self._begun.append((name, perf_counter()))

    def taken(self) -> dict[str, float]:
        """Return how long the phases took since the last call [s]."""
        ends = [begin for _, begin in self._begun[1:]] + [perf_counter()]
        total = dict.fromkeys(PHASES, 0.0)
        for (name, begin), end in zip(self._begun, ends, strict=True):
            total[name] += end - begin
        self._begun = []
        return total


class Stopwatch(Iterator[Frame]):
    """Takes the time of every frame that is simulated."""

    def __init__(self, frames: Iterator[Frame]) -> None:
        self._frames = frames
        self.seconds: list[float] = []

    def __next__(self) -> Frame:
        begin = perf_counter()
        frame = next(self._frames)
        self.seconds.append(perf_counter() - begin)
        return frame


def measure(case: Case) -> Iterator[float | Size]:
    """Yield how long each step took [s], and at last what the size came to."""
    compiling = warmed_up()
    scenario = case.scenario()
    stopwatch = Stopwatch(scenario.frames)
    first: list[Frame] = []
    phases = Phases()
    team_filter = SetMembershipFilter.light(scenario.team, scope=Window(), on_phase=phases)
    tally, conflict = Tally(Window(), phases), None
    try:
        for step in steps(team_filter, replace(scenario, frames=stopwatch)):
            if len(first) <= EKF_STEPS:
                first.append(step.frame)
            tally.add(step)
            yield step.seconds
    except Inconsistent as error:
        conflict = str(error)
    size = size_of(case, tally, stopwatch, compiling)
    if case.baselines:
        ratio = area_ratio_to_team(team_filter, tally.compared) if case.robots <= TEAM_UP_TO else None
        kalman = ekf_step_ms(scenario, case.errors, first) if case.robots <= EKF_UP_TO else None
        size = replace(size, area_ratio_to_team=ratio, ekf_step_median_ms=kalman)
    yield replace(size, conflict=conflict)


def size_of(case: Case, tally: Tally, stopwatch: Stopwatch, compiling: float) -> Size:
    """Return what the filter's own run came to; memory as of now."""
    totals, checked = tally.seconds, tally.checked
    return Size(
        robots=case.robots,
        world=case.world,
        steps=len(totals),
        compile_seconds=compiling,
        simulate_ms=quantile(stopwatch.seconds, 0.5, 1e3),
        step_median_ms=quantile(totals, 0.5, 1e3),
        step_p95_ms=quantile(totals, 0.95, 1e3),
        phases_median_ms={name: quantile(seconds, 0.5, 1e3) for name, seconds in tally.by_phase.items()},
        rows=mean(tally.rows),
        window_robots_mean=mean(tally.windows),
        window_robots_max=max(tally.windows, default=None),
        memory_mib=peak_memory_mib(),
        area_m2=mean(tally.areas),
        escapes=checked.escapes + checked.heading_escapes,
        projections=case.robots * checked.steps,
        fallbacks=checked.fallbacks,
    )


def window_sizes(belief: Belief, window: Window) -> list[int]:
    """Return how many robots are in each robot's window."""
    robots = len(belief.regions)
    who, sizes = links(belief.constraints, robots), []
    for robot in range(robots):
        place = np.full(robots, -1)
        sizes.append(len(members_of(WORLD, robot, window.hops, window.robots, who, place)))
    return sizes


def area_ratio_to_team(team_filter: SetMembershipFilter, compared: Sequence[Step[Belief]]) -> float | None:
    """Return the mean area in windows over that in the whole team, both from the same beliefs and measurements."""
    if not compared:
        return None
    whole = replace(team_filter, scope=Window.everybody())
    team = [mean_area(whole.update(step.predicted, step.frame.measurements)) for step in compared]
    return rounded(float(np.sum([mean_area(step.belief) for step in compared]) / np.sum(team)))


def ekf_step_ms(scenario: Scenario, errors: ErrorKind, frames: Sequence[Frame]) -> float | None:
    """Return the median time of a step of the joint extended Kalman filter [ms]; the first frame has no odometry: no step."""
    kalman = ExtendedKalmanFilter(scenario.team, TUNED[errors])
    begin = perf_counter()
    seconds: list[float] = []
    for step in steps(kalman, replace(scenario, frames=iter(frames))):
        seconds.append(step.seconds)
        if perf_counter() - begin > EKF_PATIENCE and len(seconds) > 1:
            break
    return quantile(seconds[1:], 0.5, 1e3)


def mean_area(belief: Belief) -> float:
    """Return the mean area of the outer polygons [m2]."""
    return float(belief.regions.outer.areas.mean())


def mean(values: Sequence[float]) -> float | None:
    """Return a mean, or None of nothing."""
    return rounded(float(np.mean(values))) if values else None


def quantile(values: Sequence[float], share: float, unit: float = 1.0) -> float | None:
    """Return a quantile in another unit, or None of nothing."""
    return rounded(float(np.quantile(values, share)) * unit) if values else None
