"""The benchmark's figure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from experiments.against_ekf.figures import INK, LOOK, PALE, SETS

NAMES = {
    "kernel": "exact, compiled window",
    "kernel_inside": "exact, with the inner polygon",
    "piqp_solve": "PIQP, one direction",
    "piqp_search": "PIQP, search to 0.999",
    "highs_warm_solve": "HiGHS warm, one direction",
    "highs_warm_search": "HiGHS warm, search to 0.999",
    "polytope": "polytope, iterative hull",
}


def draw_ratios(folder: Path, times: Mapping[str, float], robots: int) -> None:
    """Draw `ratios.png`: the median time of each way, in units of the compiled walk's."""
    order = sorted(times, key=lambda name: -times[name])
    ratios = [times[name] / times["kernel"] for name in order]
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(8.0, 3.6), layout="constrained")
        axes = figure.subplots()
        colours = [SETS if name == "kernel" else PALE for name in order]
        bars = axes.barh([NAMES[name] for name in order], ratios, 0.7, color=colours)
        words = [f"{ratio:.3g} ({1e3 * times[name]:.3g} ms)" for ratio, name in zip(ratios, order, strict=True)]
        axes.bar_label(bars, words, padding=4, fontsize=9, color=INK)
        axes.set(title=f"One robot's region in a window of {robots}: time, exact and compiled = 1", xscale="log")
        axes.set_xlim(0.5 * min(ratios), 8 * max(ratios))
        axes.grid(visible=False)
        axes.tick_params(axis="y", length=0)
        figure.savefig(folder / "ratios.png")
