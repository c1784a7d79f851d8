"""What it costs to tolerate a lie: how much larger regions are than if nobody lies, and how much longer a step takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from rich.table import Table

from experiments.beacons.outcomes import Outcome, Verdict, followed, is_known, total
from experiments.beacons.scenes import Scene
from experiments.following.metrics import Value, rounded
from experiments.show.terminal import show_table
from filter import Array, SetMembershipFilter, Tolerance

WINDOW = 2.0  # [s]; ten steps of those that drive
TOLERATED = {
    "pairs_any": Tolerance(1, WINDOW, "pairs"),
    "pairs_long": Tolerance(1, WINDOW, "pairs", "long"),
    "bodies_any": Tolerance(1, WINDOW, "bodies"),
    "bodies_long": Tolerance(1, WINDOW, "bodies", "long"),
    "cameras_any": Tolerance(1, WINDOW, "cameras"),
    "identities_any": Tolerance(1, WINDOW, "identities"),
}
IN_WORDS = {
    "pairs_any": "a pair, any lie",
    "pairs_long": "a pair, too long",
    "bodies_any": "a body, any lie",
    "bodies_long": "a body, too long",
    "cameras_any": "a robot's sensor, any lie",
    "identities_any": "of each robot a pair, any lie",
}
OF_TEAMS = {"standing": 3, "moving": 1}  # so many draws of teams, as each case is a belief of its own
STEPS = 20  # of those that drive
ALONE = ("pairs_any", "pairs_long")  # what a robot that is alone takes for a target is that body


@dataclass(frozen=True)
class Price:
    """What a tolerance costs in one scene.

    Attributes:
        setting: Which tolerance, a key of `TOLERATED`.
        strict: What the strict filter has made of the scene.
        tolerant: What the tolerant one has made of it.
        verdict: Of a judge on the strict one; None where there is none.
    """

    setting: str
    strict: Outcome
    tolerant: Outcome
    verdict: Verdict | None

    @property
    def ratios(self) -> Array:
        """How many times as large each robot's region is, after each step."""
        return np.asarray((self.tolerant.areas / self.strict.areas[: len(self.tolerant.areas)]).ravel())

    @property
    def over_exact(self) -> float | None:
        """The area over that of the exact hull of all places that agree with all ranges but one; None if nobody knows that."""
        if self.verdict is None or not is_known(self.verdict):
            return None
        return float(self.tolerant.areas[-1, 0]) / self.verdict.tolerant[TOLERATED[self.setting].lies].least


def prices_of(strict: Outcome, verdict: Verdict | None, drawn: int) -> Iterator[Price]:
    """Yield what tolerances cost in a scene that so many of its kind were drawn before; raises what the filter raises."""
    scene = strict.scene
    if scene.kind != "alone" and drawn >= OF_TEAMS.get(scene.kind, 0):
        return
    short = replace(scene, frames=scene.frames[:STEPS])
    for setting in ALONE if scene.kind == "alone" else TOLERATED:
        yield Price(setting, strict, followed(tolerant_filter(scene, setting), short), verdict)


def tolerant_filter(scene: Scene, setting: str) -> SetMembershipFilter:
    """Return the filter that tolerates a lie."""
    return SetMembershipFilter(scene.team, tolerance=TOLERATED[setting])


def summary_of_prices(prices: Sequence[Price]) -> dict[str, Value]:
    """Return flat values: what a tolerance costs beside the exact price, and beside the strict filter, by kind of scene."""
    summary: dict[str, Value] = {f"tolerant_{name}": n for name, n in total([each.tolerant for each in prices]).items()}
    for setting in ALONE:
        ratios = [each.over_exact for each in prices if each.setting == setting and each.over_exact is not None]
        summary[f"tolerance_over_exact_{TOLERATED[setting].lies}"] = rounded(max(ratios)) if ratios else None
    for kind, setting in dict.fromkeys((each.strict.scene.kind, each.setting) for each in prices):
        some = [each for each in prices if (each.strict.scene.kind, each.setting) == (kind, setting)]
        ratios_of_kind = np.concatenate([each.ratios for each in some])
        seconds = np.concatenate([each.tolerant.seconds for each in some])
        summary[f"price_{kind}_{setting}"] = rounded(float(np.median(ratios_of_kind)))
        summary[f"price_{kind}_{setting}_step_ms"] = rounded(1e3 * float(np.median(seconds)))
    return summary


def print_prices(summary: dict[str, Value], kinds: dict[str, tuple[str, int]]) -> None:
    """Print what each tolerance costs in each kind of scene, in area and in time."""
    table = Table(
        "one of these may lie", title="a tolerance: times the area if nobody lies, and ms a step", title_justify="left"
    )
    priced = [kind for kind in kinds if f"price_{kind}_pairs_any" in summary]
    for kind in priced:
        table.add_column(kinds[kind][0], justify="right")
    for setting, words in IN_WORDS.items():
        cells = [(summary.get(f"price_{kind}_{setting}"), summary.get(f"price_{kind}_{setting}_step_ms")) for kind in priced]
        table.add_row(words, *("-" if area is None else f"{area:.3g} x, {ms:.3g} ms" for area, ms in cells))
    show_table(table)
