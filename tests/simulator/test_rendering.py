"""The overview camera sees the whole arena; that can be told without drawing anything."""

import mujoco
import numpy as np
import pytest

from filter.errors import CorralError
from sim.layout import layout
from sim.rendering import HEIGHT, WIDTH, CannotRender, add_overview


def compiled(half):
    spec = mujoco.MjSpec()
    add_overview(spec, np.asarray(half))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def in_the_image(half, points):
    """Return where points (k, 3) are in the overview, (k, 2) from -1 to 1 from rim to rim, and how far ahead they are."""
    model, data = compiled(half)
    seen = (points - data.cam_xpos[0]) @ data.cam_xmat[0].reshape(3, 3)
    high = -seen[:, 2] * np.tan(np.radians(model.cam_fovy[0]) / 2)
    return np.stack([seen[:, 0] / (high * WIDTH / HEIGHT), seen[:, 1] / high], axis=1), -seen[:, 2]


def rim_of(half):
    return np.array([[x, y, 0.0] for x in (-half[0], half[0]) for y in (-half[1], half[1])])


@pytest.mark.parametrize("robots", [1, 7, 13, 30, 100])
def test_the_overview_shows_all_of_the_arena_and_little_else(robots):
    half = layout(robots).arena[1]
    where, ahead = in_the_image(half, rim_of(half))
    assert (ahead > 0).all()
    assert np.abs(where).max() < 1
    assert np.abs(where).max() > 0.75


@pytest.mark.parametrize("half", [[1.0, 10.0], [10.0, 1.0]])
def test_a_slim_arena_is_seen_as_well(half):
    where, ahead = in_the_image(half, rim_of(half))
    assert (ahead > 0).all()
    assert np.abs(where).max() < 1


def test_right_is_right_and_north_is_up():
    where, _ = in_the_image([6.0, 4.0], np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]))
    assert where[2] == pytest.approx([0, 0], abs=1e-9)
    assert where[0] == pytest.approx([where[0, 0], 0], abs=1e-9)
    assert where[0, 0] > 0
    assert where[1, 1] > 0


def test_who_cannot_draw_is_told_what_to_do():
    error = CannotRender("no display")
    assert isinstance(error, CorralError)
    assert error.reason == "no display"
    assert "MUJOCO_GL=egl" in str(error)
