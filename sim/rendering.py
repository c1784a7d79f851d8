"""Images of the world for people; optional, as it needs OpenGL."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from filter import Array, CorralError

HEIGHT, WIDTH = 640, 960  # [pixel]
FIELD_OF_VIEW = 45.0  # vertical [degree], as MuJoCo wants it
TILT = 0.35  # how far the overview looks down from the side rather than straight from above [rad]
FRAMING = 1.12  # how much more than the arena the overview shows


class CannotRender(CorralError):
    """Images need OpenGL, and there is none; everything else works without."""

    def __init__(self, reason: object) -> None:
        remedy = "set MUJOCO_GL=egl (or osmesa) before Python starts, or do without images"
        super().__init__(f"no OpenGL to draw with ({reason}): {remedy}")
        self.reason = reason


class Camera:
    """Draws a world; made when the first image is asked for, since it needs OpenGL."""

    def __init__(self, model: Any) -> None:
        try:
            self._renderer = mujoco.Renderer(model, HEIGHT, WIDTH)
        except Exception as error:  # every OpenGL platform fails in its own way
            raise CannotRender(error) from error

    def image(self, data: Any, camera: str) -> NDArray[np.uint8]:
        """Return what the named camera sees, (height, width, 3)."""
        self._renderer.update_scene(data, camera)
        return np.array(self._renderer.render(), dtype=np.uint8)


def add_overview(spec: Any, half: Array) -> None:
    """Add to the spec a camera named "overview" that sees an arena of half extents (2,) around the origin [m]."""
    fits = max(half[1], half[0] * HEIGHT / WIDTH) * FRAMING / np.tan(np.radians(FIELD_OF_VIEW) / 2) + half[1] * np.sin(TILT)
    spec.worldbody.add_camera(
        name="overview",
        pos=[0, -fits * np.sin(TILT), fits * np.cos(TILT)],
        xyaxes=[1, 0, 0, 0, np.cos(TILT), np.sin(TILT)],
        fovy=FIELD_OF_VIEW,
    )
