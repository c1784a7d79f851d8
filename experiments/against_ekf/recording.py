"""A recording of one compared run: polygons, the Kalman filter's ellipses over them, and the moments it is proved wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from experiments.following.ellipses import WIDE, WIDE_SIZE
from experiments.following.side_by_side import Case, baselines, side_by_side
from experiments.show.recording import Recording
from experiments.show.terminal import StepProgress
from filter import Alarm, Inconsistent, SetMembershipFilter, Team, watch


@dataclass
class Episodes:
    """Tells when an alarm begins and when it is over, so that a lasting one is told once.

    Attributes:
        team: Whose estimates are watched.
    """

    team: Team
    _lasting: dict[int, bool] = field(default_factory=dict)

    def changes(self, alarms: Sequence[Alarm]) -> list[tuple[str, str]]:
        """Return in words what is new, each with its level: WARN for a point, ERROR for a whole ellipse, INFO for an end."""
        now = {alarm.robot: alarm for alarm in alarms}
        words = []
        for robot, alarm in now.items():
            if robot not in self._lasting or (alarm.everything and not self._lasting[robot]):
                words.append((f"EKF proved wrong: {self.team.words(alarm)}", "ERROR" if alarm.everything else "WARN"))
        for robot in self._lasting:
            if robot not in now:
                words.append((f"the EKF's estimate of {self.team.name(robot)} is possible again", "INFO"))
        told = {robot: alarm.everything or self._lasting.get(robot, False) for robot, alarm in now.items()}
        self._lasting = told
        return words


def record(case: Case, path: Path) -> None:
    """Follow one case with the sets and the tuned Kalman filter, and record both.

    Raises:
        InvalidInput: The simulator cannot do this.
    """
    scenario = case.scenario()
    team, episodes = scenario.team, Episodes(scenario.team)
    filters = {"ekf": baselines(team, case.errors)["ekf"]}
    recording = Recording(
        path,
        team,
        recording_id=f"ekf_comparison_{case.name}",
        walls=scenario.walls,
        wall_height=scenario.wall_height,
    )
    with recording, StepProgress(scenario.count) as progress:
        try:
            for step, estimates in side_by_side(SetMembershipFilter(team), filters, scenario):
                estimate = estimates["ekf"].belief
                means, covariances = estimate.mean[:, :2], estimate.position_covariances
                alarms = watch(step.belief, means, covariances, WIDE)
                recording.add(step.frame, step.belief)
                recording.ellipses(means, covariances, WIDE_SIZE)
                recording.impossible([means[alarm.robot] for alarm in alarms])
                for words, level in episodes.changes(alarms):
                    recording.event(words, level)
                progress.advance(step.frame.time, step.seconds)
        except Inconsistent as error:
            recording.event(team.words(error), "ERROR")
