"""How a recording opens in Rerun's viewer."""

from __future__ import annotations

from collections.abc import Sequence

import rerun.blueprint as rrb

from experiments.show.colours import Colour
from experiments.show.drawing import extent_of
from filter import Team

NARROWEST = 1.3  # width over height of a view from above that still shows the whole arena
CLOSE = 12.0  # height from which a large team's middle is shown [m]
BACKGROUND: Colour = (22, 24, 29)
INDIVIDUALLY = 60  # robots at most that have entities of their own; more would slow a viewer down


def blueprint(team: Team, camera: bool, inside: bool) -> rrb.Blueprint:
    """Return how a recording opens: the arena from above, a close-up, plots of area and performance ratio, the events."""
    lower, upper = extent_of(team)
    middle, size = (lower + upper) / 2, upper - lower
    arena = _from_above("Arena from above", (*middle, 0.0), float(max(size[1], size[0] / NARROWEST)) * 1.06)
    middle_one = team.name(team.robots // 2)
    close = _from_above(f"Close-up of {middle_one}", (0.0, 0.0, 0.0), 0.5, tracked=f"/world/estimate/{middle_one}")
    if team.robots > INDIVIDUALLY:
        close = _from_above("Close-up of the middle", (*middle, 0.0), CLOSE)
    legend = rrb.PlotLegend(corner="RightTop")
    area = rrb.TimeSeriesView(origin="/area", name="Area of the outer polygons [m²]", plot_legend=legend)
    ratio = rrb.TimeSeriesView(
        origin="/performance_ratio",
        name="Performance ratio: inner over outer area",
        axis_y=rrb.ScalarAxis(range=(0.0, 1.05)),
        plot_legend=rrb.PlotLegend(visible=False),
    )
    hidden = rrb.encodings.TimelineColumn("t", visible=False)  # too narrow to be read; the text begins with the time
    columns = rrb.TextLogColumns(timeline_columns=[hidden], text_log_columns=["LogLevel", "Body"])
    events = rrb.TextLogView(origin="/events", name="Events", columns=columns)
    images = [rrb.Spatial2DView(origin="/camera", name="Camera")] if camera else []
    shares = [1.4, 1.5, 0.9, 0.95] if inside else [1.4, 1.5, 0.95]
    right = rrb.Vertical(rrb.Tabs(*images, close), area, *([ratio] if inside else []), events, row_shares=shares)
    return rrb.Blueprint(
        rrb.Horizontal(arena, right, column_shares=[2.3, 1]),
        rrb.TimePanel(timeline="t", state="collapsed"),
        collapse_panels=True,
    )


def _from_above(name: str, target: Sequence[float], height: float, tracked: str | None = None) -> rrb.Spatial3DView:
    x, y, z = target
    eye = rrb.EyeControls3D(
        kind="Orbital", position=(x, y, z + height), look_target=(x, y, z), eye_up=(0.0, 1.0, 0.0), tracking_entity=tracked
    )
    return rrb.Spatial3DView(origin="/world", name=name, background=BACKGROUND, line_grid=False, eye_controls=eye)
