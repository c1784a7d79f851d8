"""Figures 8, 11 and 14 of the paper, drawn for print."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from experiments.paper.formations import Formation, Searcher
from experiments.paper.search_curves import LAST, SEARCHES, Curves, corners_of, regular_polygon, trace, trace_of_polygon
from experiments.show.print_style import BLUE, COLUMN, FAINT, INK, ORANGE, PAGE, PINK, SKY, panels, save, style, title
from filter.arrays import Array
from filter.linear.polytope import Polytope
from filter.projection.proved import position
from filter.projection.stop import Stop

PROMISES = ((8, 0.85), (12, 0.90), (15, 0.95), (30, 0.99))  # searches and performance ratio, as section 7 ends
SHOWN = (4, 5, 6, 8, 12)  # searches of which the polygons are drawn
CIRCLE = 3600  # vertices of a polygon that stands for a circle
FRAME = np.array([-1.08, 1.08])  # of panels, times half their content's size


def ratios(areas: Array) -> Array:
    """Return (..., 27) inner over outer area of (..., 27, 2) areas; 1 where there is no area."""
    return np.where(areas[..., 1] > 0, areas[..., 0] / np.maximum(areas[..., 1], np.finfo(float).tiny), 1.0)


def gaps(areas: Array, exact: Array) -> Array:
    """Return (k, 27) outer less inner area, over the (k,) exact areas, of (k, 27, 2) areas."""
    return np.asarray((areas[..., 1] - areas[..., 0]) / exact[:, None])


def draw_convergence(folder: Path, curves: Sequence[Curves]) -> None:
    """Draw `convergence.png`: performance ratio and area gap, adaptive against uniform (Fig. 14)."""
    exact = np.array([each.area for each in curves])
    ways = {
        "largest triangle": (np.array([each.adaptive for each in curves]), BLUE),
        "uniform": (np.array([each.uniform for each in curves]), ORANGE),
    }
    with style():
        figure, (left, right) = panels(1, 2, PAGE, 2.75)
        for name, (areas, colour) in ways.items():
            ratio, gap = ratios(areas), gaps(areas, exact)
            left.plot(SEARCHES, ratio.mean(axis=0), color=colour, label=f"{name}, mean")
            left.plot(SEARCHES, ratio.min(axis=0), color=colour, linestyle=(0, (4, 2)), linewidth=1.0, label=f"{name}, worst")
            right.plot(SEARCHES, gap.mean(axis=0), color=colour)
            right.plot(SEARCHES, gap.max(axis=0), color=colour, linestyle=(0, (4, 2)), linewidth=1.0)
        searches, promised = zip(*PROMISES, strict=True)
        left.plot(searches, promised, "D", color=INK, markersize=3.5, clip_on=False, zorder=6, label="the paper's promise")
        title(left, "a", "performance ratio (eq. 7)")
        title(right, "b", "area gap (eq. 6) over the area")
        left.set(xlabel="searches", ylabel=r"Area$(\mathcal{P}^-)$ / Area$(\mathcal{P}^+)$", ylim=(0, 1.0), xlim=(4, LAST))
        right.set(xlabel="searches", ylabel=r"$\Delta\mathcal{P}$ / Area$(\mathcal{P})$", yscale="log", xlim=(4, LAST))
        right.set_ylim(1e-4, 1e2)
        for panel in (left, right):
            panel.set_xticks([4, 8, 12, 16, 20, 25, 30])
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=5, columnspacing=1.2, handlelength=1.8)
        save(figure, folder, "convergence")


def draw_worst_case(folder: Path, curves: Sequence[Curves]) -> None:
    """Draw `worst_case.png`: measured area gaps below the bounds of Lemma 7.4 (Fig. 11)."""
    gap = gaps(np.array([each.adaptive for each in curves]), np.array([each.area for each in curves]))
    circle = regular_polygon(CIRCLE)
    of_circle = gaps(trace(trace_of_polygon(circle))[None], np.array([circle.area]))[0]
    with style():
        figure, (axes,) = panels(1, 1, COLUMN, 2.9)
        axes.plot(SEARCHES, 64 / SEARCHES**2, color=INK, label=r"bound $64/s^2$ (eq. 11)")
        steps = 16 / 4.0 ** np.floor(np.log2(SEARCHES))
        axes.step(
            SEARCHES, steps, where="post", color=FAINT, linewidth=1.0, label=r"bound $16/4^{\lfloor\log_2 s\rfloor}$ (eq. 10)"
        )
        axes.plot(SEARCHES, of_circle, color=PINK, label="a circle", linewidth=1.0)
        axes.plot(SEARCHES, gap.max(axis=0), color=BLUE, linestyle=(0, (4, 2)), label=f"worst of {len(curves)} regions")
        axes.plot(SEARCHES, gap.mean(axis=0), color=BLUE, label="their mean")
        axes.set(xscale="log", yscale="log", xlabel="searches $s$", ylabel=r"$\Delta\mathcal{P}_s$ / Area$(\mathcal{P})$")
        axes.set(xlim=(4, LAST), ylim=(1e-4, 6))
        axes.set_xticks([4, 6, 8, 12, 16, 24, 30])
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.legend(loc="lower left", labelspacing=0.25, handlelength=1.8)
        save(figure, folder, "worst_case")


def draw_searches(folder: Path, formation: Formation, robot: int) -> None:
    """Draw `searches.png`: one region between inside and outside, search after search (Figs. 6 and 8)."""
    known = formation.polytope(formation.anchors([0]))
    size = known.upper - known.lower
    # In a wider box, so that what is seen are the searches' own half-planes.
    searcher = Searcher(Polytope(known.constraints, known.lower - size, known.upper + size))
    D = position(robot, len(formation))
    exact = corners_of(searcher.project(D, Stop(performance_ratio=1.0, searches=200)))
    with style():
        figure, axes = panels(1, len(SHOWN), PAGE, 2.1, sharey=True)
        lower, upper = searcher.project(D, Stop(performance_ratio=1.0, searches=SHOWN[0])).outer.bounds
        middle, half = (lower + upper) / 2, float((upper - lower).max()) / 2
        for panel, letter, count in zip(axes, "abcde", SHOWN, strict=True):
            found = searcher.project(D, Stop(performance_ratio=1.0, searches=count))
            _region(panel, exact, found.outer.vertices, None if found.inner is None else found.inner.vertices)
            title(panel, letter, f"{count} searches: {found.inner_areas[-1] / found.outer_areas[-1]:.2f}")
            panel.set(xlabel="x [m]", xlim=middle[0] + half * FRAME, ylim=middle[1] + half * FRAME, aspect="equal")
            panel.xaxis.set_major_locator(MaxNLocator(3))
        axes[0].set_ylabel("y [m]")
        outer = Patch(facecolor=ORANGE + "59", edgecolor=ORANGE, label=r"$\mathcal{P}^+$, outer")
        inner = Patch(facecolor=SKY + "8c", edgecolor=BLUE, label=r"$\mathcal{P}^-$, inner")
        line = Line2D([], [], color=INK, linewidth=0.9, linestyle=(0, (2, 1.5)), label=r"$\mathcal{P}$, exact")
        figure.legend(handles=[outer, line, inner], loc="outside lower center", ncols=3)
        save(figure, folder, "searches")


def _region(axes: Axes, exact: Array, outer: Array, inner: Array | None) -> None:
    axes.fill(*outer.T, facecolor=ORANGE + "59", edgecolor=ORANGE, linewidth=1.0)
    if inner is not None:
        axes.fill(*inner.T, facecolor="white", edgecolor="none")
        axes.fill(*inner.T, facecolor=SKY + "8c", edgecolor=BLUE, linewidth=1.0)
    around = np.concatenate([exact, exact[:1]])
    axes.plot(*around.T, color=INK, linewidth=0.9, linestyle=(0, (2, 1.5)))
