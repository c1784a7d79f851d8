"""Recordings to look at with Rerun, live and afterwards; `drawing` beside it is what is shown, `blueprint` how it opens.

Nothing else but `blueprint`, `columns` and `onlooker` imports Rerun.

Rows are kept for a second of the run's time and sent as columns, which is ten times faster than row by row.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from experiments.following.located import Located
from experiments.show.blueprint import BACKGROUND, INDIVIDUALLY, blueprint
from experiments.show.colours import Colour, colour_of, mixed
from experiments.show.columns import columns_of
from experiments.show.drawing import ALL, LABEL, PLOTTED, Drawing, Item, Layers, Points, Strips, at_height, closed
from experiments.show.onlooker import PATIENCE, Onlooker, Shown
from filter import Array, Frame, Polygon, Team

APPLICATION = "corral"
SEND_EVERY = 1.0  # [s] of the run's time
ROOM = 16 << 20  # that there has to be for what is sent next [bytes]: on a full disk Rerun's own writer waits for ever
WALL: Colour = (112, 118, 130)
INK: Colour = (245, 246, 248)
ELLIPSE: Colour = (255, 214, 102)  # of another estimator
ALARM: Colour = (255, 76, 76)
ELLIPSE_HEIGHT = 0.040  # above every other layer [m]
CROWDED = 0.4  # size of a large team's points and lines, relative to a small one's
CIRCLE = np.array([(np.cos(turn), np.sin(turn)) for turn in np.linspace(0, 2 * np.pi, 33)])
RAYS: dict[str, Colour] = {"bearing": (84, 90, 102), "range": (62, 67, 77)}


def ui_points(width: float) -> float:
    """Return a radius that is the same on the screen at any zoom: half of `width` [points]."""
    return -width / 2


class Recording:
    """Records a run as `.rrd`, and shows it while it goes on if asked to.

    Use as a context manager, or call `close`: only then the file is whole.
    """

    def __init__(
        self,
        path: Path | None,
        team: Team,
        *,
        recording_id: str,
        walls: Array,
        wall_height: float,
        camera: bool = False,
        inside: bool = True,
        viewer: str | None = None,
        live: bool = False,
    ) -> None:
        """Open the file and draw what never moves.

        Args:
            path: The `.rrd` file, or None for a viewer alone.
            team: Whose run it is.
            recording_id: The same for two runs that shall be compared.
            walls: (w, 4) lower x, lower y, upper x, upper y of each wall [m]; without any, the arena is outlined.
            wall_height: [m].
            camera: Whether there will be images, which need a place.
            inside: Whether anything will be known from inside; else there is no performance ratio to plot.
            viewer: Address of a live viewer (see `experiments.show.viewer`), or None.
            live: Whether nobody must wait: rows are sent ten times as often, and a viewer that is behind misses some.

        Raises:
            OSError: The file cannot be written, or there is no room for it.
        """
        self._path, self._send_every = path, SEND_EVERY / (10 if live else 1)
        self._look_for_room()
        opened = partial(_stream, recording_id, blueprint(team, camera, inside))
        try:
            self._file = opened(rr.FileSink(path)) if path else None
        except RuntimeError as error:
            raise OSError(errno.EIO, str(error), str(path)) from None
        self._onlooker = Onlooker(lambda: opened(rr.GrpcSink(viewer)), 0.0 if live else PATIENCE) if viewer else None
        self._drawing = Drawing(team) if team.robots <= INDIVIDUALLY else Layers(team)
        self._rows: dict[str, list[tuple[int, float, Any]]] = defaultdict(list)
        self._step, self._time, self._sent = -1, 0.0, -np.inf
        self._styled: set[str] = set()
        self._draw_world(team, walls, wall_height)
        self._draw_robots(team)

    def add(self, frame: Frame, belief: Located) -> None:
        """Record one step."""
        self._step, self._time = self._step + 1, frame.time
        for path, item in self._drawing.items(frame, belief):
            self._put(path, item)
        if abs(self._time - self._sent) >= self._send_every:  # clocks may be set back
            self.send()

    def truth(self, frame: Frame) -> None:
        """Record the truth that a frame has, at its own time, with the last step; the frame need not be one of a step."""
        if frame.truth is not None:
            for path, item in self._drawing.truths(frame.truth):
                self._rows[path].append((self._step, frame.time, item))

    def ellipses(self, means: Array, covariances: Array, size: float) -> None:
        """Record another estimator's ellipses e' P^-1 e <= size at the last step, over the polygons.

        Args:
            means: (n, 2) [m].
            covariances: (n, 2, 2) [m2].
            size: Quantile of the chi-square distribution with two degrees of freedom.
        """
        variances, axes = np.linalg.eigh(covariances)
        roots = axes * np.sqrt(np.maximum(variances, 0))[:, None]  # an estimate may be exact: a point
        for robot, (mean, root) in enumerate(zip(means, roots, strict=True)):
            path = f"/world/ellipse/{self._drawing.team.name(robot)}"
            self._style_once(path, rr.LineStrips3D.from_fields(colors=ELLIPSE, radii=ui_points(1.6)))
            line = mean + np.sqrt(size) * CIRCLE @ root.T
            self._put(path, Strips((np.column_stack([line, np.full(len(line), ELLIPSE_HEIGHT)]),)))

    def impossible(self, points: Sequence[Array]) -> None:
        """Mark (2,) points that are proved to be wrong at the last step [m]; none for no mark."""
        path = "/world/impossible"
        self._style_once(path, rr.Points3D.from_fields(colors=ALARM, radii=ui_points(8), point_shading="flat"))
        self._put(path, Points(np.array([(*point, ELLIPSE_HEIGHT) for point in points]).reshape(-1, 3)))

    def suspended(self, outlines: Mapping[int, Polygon]) -> None:
        """Outline in red the regions (by robot) that are not guaranteed at the last step; the others lose their outline."""
        for robot in range(self._drawing.team.robots):
            path = f"/world/suspended/{self._drawing.team.name(robot)}"
            self._style_once(path, rr.LineStrips3D.from_fields(colors=ALARM, radii=ui_points(2.4)))
            self._put(path, Strips((closed(outlines[robot], "estimate"),) if robot in outlines else ()))

    def rejected(self, lines: Sequence[Array]) -> None:
        """Draw in red (2, 2) lines from robots to what they measured, of measurements rejected at the last step [m]."""
        path = "/world/rays/rejected"
        self._style_once(path, rr.LineStrips3D.from_fields(colors=ALARM, radii=ui_points(2.0)))
        self._put(path, Strips(tuple(at_height(line, "estimate") for line in lines)))

    def event(self, text: str, level: str = "INFO") -> None:
        """Enter an event at the time of the last step; level is INFO, WARN or ERROR."""
        self._put("/events", (f"{self._time:.1f} s: {text}", level))

    def image(self, pixels: NDArray[np.uint8]) -> None:
        """Record a (height, width, 3) image of the last step."""
        found = rr.Image(pixels).compress(jpeg_quality=85)
        self._show(partial(_pictured, time=self._time, step=self._step, image=found))

    def send(self) -> None:
        """Send the rows that wait.

        Raises:
            OSError: The disk is full.
        """
        self._look_for_room()
        sent = dict[str, Any]()
        for path, rows in self._rows.items():
            steps, times, items = zip(*rows, strict=True)
            indexes = [rr.TimeColumn("t", duration=times), rr.TimeColumn("step", sequence=steps)]
            sent[path] = indexes, columns_of(items)
        self._show(partial(_sent, sent))
        self._rows.clear()
        self._sent = self._time

    def close(self) -> None:
        """Send what is left and end the file."""
        try:
            self.send()
        finally:
            if self._file:
                self._file.disconnect()
            if self._onlooker:
                self._onlooker.close()

    def _look_for_room(self) -> None:
        if self._path and shutil.disk_usage(self._path.parent).free < ROOM:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._path))

    def _put(self, path: str, item: Item | tuple[str, str]) -> None:
        self._rows[path].append((self._step, self._time, item))

    def _static(self, path: str, archetype: Any) -> None:
        self._show(lambda stream: stream.log(path, archetype, static=True, strict=True), for_sure=True)

    def _show(self, what: Shown, *, for_sure: bool = False) -> None:
        """Put something into the file, and have it shown to whoever looks on."""
        if self._file:
            what(self._file)
        if self._onlooker:
            self._onlooker.show(what, for_sure=for_sure)

    def _style_once(self, path: str, archetype: Any) -> None:
        if path not in self._styled:
            self._styled.add(path)
            self._static(path, archetype)

    def _draw_world(self, team: Team, walls: Array, height: float) -> None:
        self._static("/world", rr.ViewCoordinates.RIGHT_HAND_Z_UP)
        if not len(walls) and np.isfinite(team.arena).all():
            outline = closed(Polygon.box(*team.arena), "outer")
            self._static("/world/walls", rr.LineStrips3D([outline], colors=WALL, radii=ui_points(4)))
        if len(walls):
            middles, sizes = (walls[:, :2] + walls[:, 2:]) / 2, walls[:, 2:] - walls[:, :2]
            centers = np.column_stack([middles, np.full(len(walls), height / 2)])
            half_sizes = np.column_stack([sizes / 2, np.full(len(walls), height / 2)])
            self._static("/world/walls", rr.Boxes3D(centers=centers, half_sizes=half_sizes, colors=WALL, fill_mode="solid"))
        if len(team.landmarks):
            places = np.column_stack([team.landmarks, np.full(len(team.landmarks), 0.05)])
            names = [team.name(team.robots + k) for k in range(len(places))]
            self._static("/world/landmarks", rr.Points3D(places, colors=INK, radii=ui_points(11), point_shading="flat"))
            below = places - [0, 2 * LABEL, 0]
            self._static("/world/label/landmarks", rr.Points3D(below, colors=INK, radii=0.0, labels=names, show_labels=True))
        for kind, colour in RAYS.items():
            self._static(f"/world/rays/{kind}", rr.LineStrips3D.from_fields(colors=colour, radii=ui_points(1.0)))

    def _draw_robots(self, team: Team) -> None:
        colours = [mixed(colour_of(robot), INK, 0.15) for robot in range(team.robots)]  # lighter, for the dark ground
        if team.robots > INDIVIDUALLY:
            self._style(ALL, colours)
            self._plots(PLOTTED, [INK, RAYS["bearing"], ALARM])
            return
        names = [team.name(robot) for robot in range(team.robots)]
        for name, colour in zip(names, colours, strict=True):
            self._style(name, [colour])
            self._static(f"/world/label/{name}", rr.Points3D.from_fields(colors=INK, radii=0.0, labels=name, show_labels=True))
        self._plots(names, colours)

    def _style(self, name: str, colours: Sequence[Colour]) -> None:
        """Say how the layers of one robot look, or those of several that share them."""
        lines, points = rr.LineStrips3D.from_fields, rr.Points3D.from_fields
        alone = len(colours) == 1
        size = 1.0 if alone else CROWDED
        fill, inner = (colours[0], mixed(colours[0], INK, 0.5)) if alone else (INK, INK)
        trail = [mixed(colour, BACKGROUND, 0.5) for colour in colours]
        self._static(f"/world/fill/{name}", rr.Mesh3D.from_fields(albedo_factor=(*fill, 50)))
        self._static(f"/world/outer/{name}", lines(colors=colours, radii=ui_points(2.4 * size)))
        self._static(f"/world/inner/{name}", lines(colors=inner, radii=ui_points(1.0)))
        self._static(f"/world/trail/{name}", lines(colors=trail, radii=ui_points(1.5)))
        self._static(f"/world/truth/{name}", points(colors=colours, radii=ui_points(9 * size), point_shading="flat"))
        self._static(f"/world/heading/{name}", rr.Arrows3D.from_fields(colors=colours, radii=ui_points(3 * size)))
        self._static(f"/world/estimate/{name}", points(colors=INK, radii=ui_points(4 * size), point_shading="flat"))

    def _plots(self, names: Sequence[str], colours: Sequence[Colour]) -> None:
        for name, colour in zip(names, colours, strict=True):
            self._static(f"/area/{name}", rr.SeriesLines(colors=colour, names=name, widths=1.5, aggregation_policy="Off"))
            self._static(f"/performance_ratio/{name}", rr.SeriesLines(colors=colour, names=name, widths=1.0))

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def _stream(recording_id: str, opens: rrb.Blueprint, sink: Any) -> rr.RecordingStream:
    """Return a stream into one sink, which sends what it is told to and nothing by itself."""
    batches = rr.ChunkBatcherConfig(flush_tick=3600.0, flush_num_bytes=1 << 26, flush_num_rows=1 << 20)
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id, send_properties=False, batcher_config=batches)
    stream.set_log_time_enabled(False)
    stream.set_sinks(sink, default_blueprint=opens)
    return stream


def _sent(rows: Mapping[str, Any], stream: rr.RecordingStream) -> None:
    for path, (indexes, columns) in rows.items():
        stream.send_columns(path, indexes, columns, strict=True)


def _pictured(stream: rr.RecordingStream, time: float, step: int, image: Any) -> None:
    stream.set_time("t", duration=time)
    stream.set_time("step", sequence=step)
    stream.log("/camera", image)
    stream.reset_time()
