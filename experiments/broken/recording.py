"""A recording of one episode: regions, red where their guarantee is suspended, and what happens in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.broken.episodes import Episode
from experiments.broken.fault import Fault
from experiments.broken.named import named_by
from experiments.broken.outcome import Case, filter_for, first_provable, steps_of
from experiments.following.located import outers
from experiments.show.recording import Recording
from filter import Team


def record_episode(case: Case, path: Path) -> None:
    """Follow an episode once more and record it as `.rrd`."""
    episode = case.episode()
    steps = list(steps_of(episode, filter_for(episode)))
    provable = first_provable(episode, steps)
    name = f"faults_{case.kind}_{case.seed}_{case.number}"
    with Recording(path, episode.team, recording_id=name, walls=np.zeros((0, 4)), wall_height=0.0) as recording:
        for number, step in enumerate(steps):
            belief = step.belief
            recording.add(step.frame, belief)
            regions = outers(belief)
            recording.suspended({robot: regions[robot] for robot in np.flatnonzero(~belief.guarantee.in_force).tolist()})
            for words, level in _news(episode, number, provable):
                recording.event(words, level)
            for event in belief.events:
                recording.event(episode.team.words(event), "WARN")
            for kind, bodies in sorted(named_by(belief)):
                recording.event(f"put aside: {kind} of {_names(episode.team, bodies)}")


def _news(episode: Episode, number: int, provable: int | None) -> list[tuple[str, str]]:
    """Return what is known of a frame from outside the filter, with the level of each."""
    fault, news = episode.fault, list[tuple[str, str]]()
    if number == fault.when:
        news.append((f"from now on: {in_words(fault, episode.team)}", "ERROR"))
    if number == provable:
        news.append(("the judge proves that a bound is broken", "ERROR"))
    if number == fault.until:
        news.append(("every bound holds again", "INFO"))
    return news


def in_words(fault: Fault, team: Team) -> str:
    """Return a fault in words."""
    kind, bodies = fault.guilty
    size = f"{np.hypot(*fault.offset):.2f} m, {np.degrees(fault.turn):.0f} degrees"
    return f"{fault.kind} of {size}; to blame is the {kind} of {_names(team, bodies)}"


def _names(team: Team, bodies: tuple[int, ...]) -> str:
    return " and ".join(map(team.name, bodies))
