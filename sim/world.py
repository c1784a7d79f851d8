"""The MuJoCo world: an arena with n robots in it; steps the physics and tells the truth."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from filter import Array, Integers, wrap
from models import ARENA, DIFFDRIVE
from sim.layout import Layout
from sim.rendering import Camera, add_overview

TIMESTEP = 0.005  # [s]
SETTLING_STEPS = 60  # robots are put down a hair off their rest; this long they come to it
WALL_HEIGHT = 0.3  # [m]
BEACON_RADIUS = 0.03  # [m]
HULL_BIT = 2  # what hulls, masts and walls collide by


class World:
    """Robots 0, 1, ..., n - 1 in an arena, at one instant.

    Attributes:
        robots: Number of robots n.
        arena: (2, 2) lower and upper corner of the box inside the outer walls [m].
        walls: (w, 4) lower x, lower y, upper x, upper y of each wall [m].
        wall_height: Height of the walls [m].
        landmarks: (l, 2) positions of the beacons [m].
        homes: (n, 4) lower x, lower y, upper x, upper y of each robot's home zone [m].
        track: Distance between a robot's two wheels [m].
        wheel_radius: Nominal radius of a wheel [m].
        robot_radius: Radius of the disc around the axle that covers a robot at any heading [m].
        mast_radius: Radius of what hides other robots at the height of the sensors [m].
        time: Physics time since the robots came to rest [s].
    """

    def __init__(self, plan: Layout, positions: Array, headings: Array) -> None:
        """Build the world and let the robots come to rest.

        Args:
            plan: Arena, walls, beacons and home zones.
            positions: (n, 2) where the robots start [m].
            headings: (n,) their yaws [rad].
        """
        self.robots = len(positions)
        self.arena, self.walls, self.landmarks, self.homes = plan.arena, plan.walls, plan.beacons, plan.homes
        self.wall_height = WALL_HEIGHT
        self.model = _spec(plan, positions, headings).compile()
        self.data = mujoco.MjData(self.model)
        self.track, self.wheel_radius, self.robot_radius, self.mast_radius = robot_dimensions()
        self._find_columns()
        self._camera: Camera | None = None
        self._steps = -SETTLING_STEPS
        self.step(SETTLING_STEPS)

    def _find_columns(self) -> None:
        """Look up once where in MuJoCo's arrays the robots are."""
        names = [f"r{robot}/" for robot in range(self.robots)]
        self._axles = np.array([self.model.site(name + "axle").id for name in names])
        self._compasses = self._columns([name + "magnetometer" for name in names])
        sides = [[name + side for side in ("left", "right")] for name in names]
        self._encoders = np.array([self._columns([side + "_encoder" for side in both]) for both in sides])
        self._motors = np.array([[self.model.actuator(side + "_motor").id for side in both] for both in sides])

    def _columns(self, sensors: list[str]) -> Integers:
        return np.array([self.model.sensor(sensor).adr[0] for sensor in sensors])

    @property
    def time(self) -> float:
        """Physics time since the robots came to rest [s]."""
        return self._steps * TIMESTEP

    def positions(self) -> Array:
        """Return (n, 2) where the middles of the axles are [m]."""
        return np.array(self.data.site_xpos[self._axles, :2])

    def headings(self) -> Array:
        """Return (n,) yaws in (-pi, pi] [rad], as a perfect compass shows them."""
        north = self.data.sensordata
        return wrap(np.arctan2(-north[self._compasses + 1], north[self._compasses]))

    def wheel_angles(self) -> Array:
        """Return (n, 2) angles that left and right wheel have turned since they were built, not wrapped [rad]."""
        return np.array(self.data.sensordata[self._encoders])

    def command(self, wheel_speeds: Array) -> None:
        """Set the (n, 2) speeds that left and right motors strive for [rad/s]."""
        self.data.ctrl[self._motors] = wheel_speeds

    def step(self, steps: int = 1) -> None:
        """Advance the physics by `steps` timesteps of 5 ms and bring what the sensors see up to date."""
        mujoco.mj_step(self.model, self.data, nstep=steps)
        # mj_step leaves poses and sensors one step behind; mj_forward would bring everything up to date, at far more cost.
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_sensorPos(self.model, self.data)
        self._steps += steps

    def collisions(self) -> int:
        """Return how many contacts of hulls or masts with anything there were at the last step."""
        geoms = self.data.contact.geom
        return int((self.model.geom_contype[geoms] & HULL_BIT).any(axis=1).sum())

    def render(self, camera: str = "overview") -> NDArray[np.uint8]:
        """Return an image of the world, (height, width, 3).

        Raises:
            CannotRender: There is no OpenGL here.
        """
        if self._camera is None:
            self._camera = Camera(self.model)
        return self._camera.image(self.data, camera)


def robot_dimensions() -> tuple[float, float, float, float]:
    """Return a robot's track, the radius of its wheels, of the disc around the axle that covers it, and of its mast [m]."""
    model = mujoco.MjModel.from_xml_path(str(DIFFDRIVE))
    hull, mast, wheel = (model.geom(name) for name in ("hull", "mast", "left_tyre"))
    cover = hull.size[0] + np.hypot(*hull.pos[:2])
    return float(2 * model.body("left_wheel").pos[1]), float(wheel.size[0]), float(cover), float(mast.size[0])


def _spec(plan: Layout, positions: Array, headings: Array) -> Any:
    spec = mujoco.MjSpec.from_file(str(ARENA))
    spec.copy_during_attach = True
    half = (plan.arena[1] - plan.arena[0]) / 2
    spec.geom("floor").size = [*(half + 1), 0.1]
    add_overview(spec, half)
    for index, wall in enumerate(plan.walls):
        _add_wall(spec, index, wall)
    for index, beacon in enumerate(plan.beacons):
        _add_beacon(spec, index, beacon)
    robot = mujoco.MjSpec.from_file(str(DIFFDRIVE))
    for index, (position, heading) in enumerate(zip(positions, headings, strict=True)):
        turn = [np.cos(heading / 2), 0, 0, np.sin(heading / 2)]
        spec.attach(robot, prefix=f"r{index}/", frame=spec.worldbody.add_frame(pos=[*position, 0], quat=turn))
    return spec


def _add_wall(spec: Any, index: int, wall: Array) -> None:
    middle, half = (wall[:2] + wall[2:]) / 2, (wall[2:] - wall[:2]) / 2
    spec.worldbody.add_geom(
        name=f"wall{index}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[*middle, WALL_HEIGHT / 2],
        size=[*half, WALL_HEIGHT / 2],
        material="wall",
        contype=HULL_BIT,
        conaffinity=HULL_BIT,
    )


def _add_beacon(spec: Any, index: int, position: Array) -> None:
    spec.worldbody.add_geom(
        name=f"beacon{index}",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[*position, WALL_HEIGHT],
        size=[BEACON_RADIUS, WALL_HEIGHT, 0],
        material="beacon",
        contype=0,
        conaffinity=0,
    )
