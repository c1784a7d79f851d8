"""Who may import whom, and how long a module may be."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("filter", "sim", "models", "experiments")
LONGEST = 300
# The filter's records: all that the simulator knows of it.
RECORDS = {"filter.measurements", "filter.team", "filter.angles", "filter.arrays", "filter.errors"}
# No files, no clock, no randomness: what the filter may use besides numpy, scipy and the solvers.
PLAIN = {
    "__future__",
    "abc",
    "collections",
    "dataclasses",
    "enum",
    "fractions",
    "functools",
    "itertools",
    "math",
    "operator",
    "typing",
}
# What some modules of the filter may use besides.
# What some modules with compiled functions import for the others of their functions.
NOT_IN_LOOPS = {"windows": {"EXACT"}, "boxes": {"SIDES"}}
COMPILED = (
    "angles",
    "plane",
    "polygons",
    "constraints",
    "lp",
    "motion",
    "pruning",
    "simplex",
    "shadow",
    "window",
    "windowed",
    "windows",
    "headings",
    "boxes",
    "corners",
    "slices",
    "estimating",
)
AND = {
    "compiled": {"numba", "hashlib", "pathlib"},
    "solvers": {"piqp", "qpsolvers", "highspy"},
    "windows": {"concurrent", "os"},
}
MODULES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
ORDER = [
    "errors",
    "arrays",
    "compiled",
    "angles",
    "plane",
    "polygon",
    "polygons",
    "constraints",
    "lp",
    "scaling",
    "solvers",
    "polytope",
    "reference",
    "measurements",
    "team",
    "sensing",
    "motion",
    "projection",
    "search",
    "pruning",
    "simplex",
    "shadow",
    "exact",
    "budget",
    "projector",
    "window",
    "windowed",
    "outlines",
    "windows",
    "region",
    "belief",
    "headings",
    "boxes",
    "corners",
    "regions",
    "pairs",
    "rejection",
    "set_membership",
    "slices",
    "sightings",
    "hypotheses",
    "cuts",
    "voting",
    "trust",
    "alignment",
    "estimating",
    "robust_belief",
    "leaving",
    "merging",
    "robust",
    "lag",
    "ekf",
    "watch",
]


def folder(path):
    return path.relative_to(ROOT).parts[0]


def imports(path):
    """Return the full names that a module imports, with `from a import b` as a and, when b is a module of ours, a.b."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            modules = {f"{node.module}.{alias.name}" for alias in node.names}
            ours = {name for name in modules if (ROOT / Path(*name.split("."))).with_suffix(".py").exists()}
            names |= ours or {node.module}
    return names


def top(name):
    return name.split(".")[0]


def of(name):
    return [pytest.param(path, id=str(path.relative_to(ROOT))) for path in MODULES if folder(path) == name]


def everyone():
    return [pytest.param(path, id=str(path.relative_to(ROOT))) for path in MODULES]


def test_there_are_modules_to_look_at():
    assert {folder(path) for path in MODULES} == set(FOLDERS)
    assert {path.stem for path in MODULES if folder(path) == "filter"} >= set(ORDER)


@pytest.mark.parametrize("path", of("filter"))
def test_the_filter_stands_alone(path):
    allowed = {"filter", "numpy", "scipy", *PLAIN} | AND.get(path.stem, set())
    assert {top(name) for name in imports(path)} <= allowed
    assert not any(name.startswith("numpy.random") for name in imports(path))


@pytest.mark.parametrize("path", of("filter"))
def test_the_filter_has_no_files_and_no_randomness(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in ("open", "print", "input", "exec", "eval", "__import__")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np":
            assert node.attr not in ("random", "save", "savez", "load", "savetxt", "loadtxt")


@pytest.mark.parametrize("path", [pytest.param(ROOT / "filter" / f"{name}.py", id=name) for name in ORDER])
def test_the_filter_reads_in_one_order(path):
    before = {f"filter.{name}" for name in ORDER[: ORDER.index(path.stem)]}
    assert {name for name in imports(path) if top(name) == "filter"} <= before


def test_what_is_compiled_is_said_to_be():
    marked = {path.stem for path in MODULES if folder(path) == "filter" and "\n@compiled\n" in path.read_text()}
    assert marked == set(COMPILED)


@pytest.mark.parametrize("name", COMPILED)
def test_constants_of_what_is_compiled_are_from_there(name):
    """They become a part of the compiled code, which is made anew when a module with compiled functions changes."""
    tree = ast.parse((ROOT / "filter" / f"{name}.py").read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module.startswith("filter."):
            constants = [alias.name for alias in node.names if alias.name.isupper()]
            elsewhere = set(constants) - NOT_IN_LOOPS.get(name, set())
            assert not elsewhere or node.module.removeprefix("filter.") in COMPILED, elsewhere


@pytest.mark.parametrize("path", of("sim"))
def test_the_simulator_knows_the_filters_records_only(path):
    ours = {name for name in imports(path) if top(name) in FOLDERS}
    assert {name for name in ours if top(name) == "filter"} <= RECORDS
    assert {top(name) for name in ours} <= {"filter", "sim", "models"}


@pytest.mark.parametrize("path", of("models"))
def test_models_know_nobody(path):
    assert not {name for name in imports(path) if top(name) in FOLDERS and top(name) != "models"}


@pytest.mark.parametrize("path", everyone())
def test_solvers_physics_and_recording_are_in_their_places(path):
    names = {top(name) for name in imports(path)}
    relative = str(path.relative_to(ROOT))
    assert relative == "filter/solvers.py" or not names & {"piqp", "qpsolvers", "highspy"}
    assert folder(path) == "sim" or "mujoco" not in names
    assert relative == "experiments/recording.py" or "rerun" not in names


@pytest.mark.parametrize("path", [*everyone(), *(pytest.param(p, id=p.name) for p in sorted((ROOT / "tests").glob("*.py")))])
def test_nobody_hides_the_builtin_filter(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            assert not any(top(alias.name) == "filter" and alias.asname is None for alias in node.names)


def test_there_is_no_package_of_tests_that_hides_the_filter():
    assert not (ROOT / "tests" / "filter").exists()
    assert not (ROOT / "tests" / "__init__.py").exists()


@pytest.mark.parametrize("path", of("filter"))
def test_no_module_of_the_filter_is_too_long(path):
    assert len(path.read_text().splitlines()) <= LONGEST
