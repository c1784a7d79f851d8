"""What the monitor has found, as numbers, as a sentence and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from rich.table import Table

from experiments.following.metrics import Value, rounded
from experiments.show.terminal import show_table
from experiments.watchdog.episodes import Episode
from experiments.watchdog.watching import Judged


def summary_of(judged: Judged) -> dict[str, Value]:
    """Return what was watched, and how much of it is proved wrong."""
    claims, episodes = judged.claims, judged.episodes
    said = np.array([np.isfinite(claimed.positions[:, :, 0]).any(axis=0) for claimed in claims])
    return {
        "robots": int(said.any(axis=0).sum()),
        "trajectories": int(said.sum()),
        "poses": sum(claimed.poses() for claimed in claims),
        "checks": judged.checks,
        "before_first_frame": sum(claimed.poses(until=judged.first) for claimed in claims),
        "after_last_frame": sum(claimed.poses(after=judged.last) for claimed in claims),
        "alarms": judged.alarms,
        "alarm_share": rounded(judged.alarms / judged.checks) if judged.checks else None,
        "episodes": len(episodes),
        "distance_max_m": rounded(max((episode.worst.distance for episode, _ in episodes), default=0.0)),
    }


def sentence(summary: Mapping[str, Value]) -> str:
    """Return the summary in words."""
    judged = (
        "{checks} of {poses} poses were judged: {before_first_frame} are before the log's first frame, {after_last_frame} after"
    )
    wrong = "{alarms} are proved wrong, in {episodes} episode" + "s" * (summary["episodes"] != 1)
    return f"{judged} its last. {wrong}, if every bound of the log holds.".format(**summary)


def print_episodes(episodes: Sequence[tuple[Episode, str]], *, stderr: bool = False) -> None:
    """Print a table of episodes, each with what is behind it, if there are any, to stdout, or else to stderr."""
    table = Table("trajectory", "from [s]", "to [s]", "poses", "beyond [m]", "proved at its worst by", title="Proved wrong")
    for episode, behind in episodes:
        numbers = (f"{episode.start:.3f}", f"{episode.end:.3f}", str(episode.poses), f"{episode.worst.distance:.3f}")
        table.add_row(episode.trajectory, *numbers, behind)
    if episodes:
        show_table(table, stderr=stderr)
