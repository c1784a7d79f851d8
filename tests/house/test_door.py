"""The door: everything that a user names is there, who comes from outside goes through it, and it costs what it must."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import filter as door

ROOT = Path(__file__).parents[2]
# Experiments on the machinery itself, which may change with it.
WORKSHOPS = ("timed", "optimum", "paper", "proof", "growth")
# What else goes past the door, and for what.
PAST = {
    "experiments/certified_bounds.py": "linear programs, with and without a proof",
    "experiments/following/frozen.py": "the checks of numbers and arrays that all records share",
    "experiments/logs/cases.py": "how a robot's poses were split, and which rows the pieces are cut from",
    "experiments/logs/alternatives.py": "what is tried in a doubt, and who has to be suspected",
    "experiments/logs/evidence.py": "the table of sources, to find the ranges that something rests on",
    "experiments/logs/checks.py": "the same checks, for all of logs",
    "experiments/logs/exactly.py": "rows",
    "experiments/logs/sides.py": "where targets are at a glance, to prove what the filter took from that",
    "experiments/logs/votes.py": "which slices agree with every vote, and which do without one",
    "experiments/watchdog/behind.py": "which readings concern a robot, whose poses were found in cells by them",
}


def imported(path):
    """Return the pairs of module and name that a file imports from the filter."""
    nodes = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom)]
    return [(node.module, alias.name) for node in nodes if node.module.split(".")[0] == "filter" for alias in node.names]


def visitors():
    paths = [*(ROOT / "experiments").rglob("*.py"), *(ROOT / "sim").rglob("*.py")]
    return [path for path in sorted(paths) if path.parent.name not in WORKSHOPS]


def loaded_by(program, *modules):
    """Return which of some modules a program loads."""
    told = f"import sys\n{program}\nprint(*(name for name in {modules} if name in sys.modules))"
    return subprocess.run([sys.executable, "-c", told], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()


def test_every_name_at_the_door_is_there_once_and_can_be_looked_up():
    assert len(set(door.__all__)) == len(door.__all__)
    assert [name for name in door.__all__ if not hasattr(door, name)] == []
    public = {name for name, value in vars(door).items() if not name.startswith("_") and not _is_module(value)}
    assert public == set(door.__all__)


def _is_module(value):
    return isinstance(value, type(sys))


def test_what_a_user_names_is_at_the_door():
    filters = {"SetMembershipFilter", "RobustFilter", "ExtendedKalmanFilter", "FixedLag", "Filter", "follow", "Step", "watch"}
    given = {"Team", "Frame", "Truth", "Polygon", "AngularIntervals", "Compass", "Bearing", "Range", "Odometry", "NoiseModel"}
    told = {"Belief", "GaussianBelief", "Region", "Source", "Turned", "Alarm", "CorralError"}
    assert filters | given | told <= set(door.__all__)


def test_every_error_is_at_the_door():
    errors = ast.parse((ROOT / "filter/errors.py").read_text()).body
    assert {node.name for node in errors if isinstance(node, ast.ClassDef)} <= set(door.__all__)


@pytest.mark.parametrize("path", visitors(), ids=lambda path: str(path.relative_to(ROOT)))
def test_what_is_at_the_door_is_imported_there(path):
    assert [name for module, name in imported(path) if module != "filter" and name in door.__all__] == []


def test_few_go_past_the_door():
    deep = [str(path.relative_to(ROOT)) for path in visitors() if any(module != "filter" for module, _ in imported(path))]
    assert [path for path in deep if path.startswith("experiments/")] == sorted(PAST)


def test_the_door_says_that_it_is_typed_and_the_wheel_has_it():
    assert (ROOT / "filter/py.typed").exists()
    built = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]
    assert "filter" in built["targets"]["wheel"]["packages"]  # whole, as nothing is left out
    assert not {"exclude", "only-include"} & (set(built) | set(built["targets"]["wheel"]))


def test_importing_the_filter_loads_nothing_that_it_can_do_without():
    assert loaded_by("import filter", "scipy.stats", "scipy.special", "matplotlib", "mujoco", "rerun", "rich", "tyro") == []


@pytest.mark.parametrize("name", ["logs", "following.scenarios", "following.steps"])
def test_reading_a_log_loads_neither_simulator_nor_recorder(name):
    program = f"import experiments.{name}"
    assert loaded_by(program, "mujoco", "sim", "rerun", "matplotlib", f"experiments.{name}") == [f"experiments.{name}"]
