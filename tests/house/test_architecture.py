"""Who may import whom, in which order the filter reads, and how long a module or a folder may be."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("filter", "sim", "models", "experiments")
LONGEST = 300
FULLEST = 15
# The filter's records: all that the simulator knows of it.
RECORDS = {
    "filter.records.frame",
    "filter.records.measurements",
    "filter.records.odometry",
    "filter.records.record",
    "filter.team",
    "filter.geometry.angles",
    "filter.arrays",
    "filter.errors",
}
# No files, no clock, no randomness: what the filter may use besides numpy, scipy and the solvers.
PLAIN = {
    "__future__",
    "abc",
    "collections",
    "dataclasses",
    "decimal",
    "difflib",
    "enum",
    "fractions",
    "functools",
    "heapq",
    "itertools",
    "math",
    "operator",
    "re",
    "typing",
}
# What some modules of the filter may use besides.
AND = {
    "filter.workers": {"_thread", "atexit", "contextlib", "os", "queue"},
    "filter.compiled": {"numba", "contextlib", "hashlib", "os", "pathlib", "stat", "sys", "tempfile"},
    "filter.linear.solvers": {"piqp", "qpsolvers", "highspy", "importlib"},
    "filter.projection.team": {"os"},
}
# What a compiled function may return to Python: see `filter.compiled`.
NUMBERS, ONE_ARRAY = {"None", "bool", "int", "float"}, {"Array", "Integers", "Mask"}
MODULES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))


@cache
def nodes_of(path):
    """Return all nodes of a module's syntax tree, itself first."""
    return list(ast.walk(ast.parse(path.read_text())))


def name_of(path):
    """Return a module's full name; a package's is that of its folder."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {name_of(path): path for path in MODULES}


def order_of(package):
    """Return the full names of the filter's modules in the order in which its packages say they are read."""
    said = ast.get_docstring(ast.parse((ROOT / package.replace(".", "/") / "__init__.py").read_text()))
    listed = re.search(r"\border[^:]*: (.*?)\.$", said, re.DOTALL | re.MULTILINE).group(1)
    names = []
    for entry in re.split(r",\s+", listed):
        names += order_of(f"{package}.{entry[:-1]}") if entry.endswith("/") else [f"{package}.{entry}"]
    return names


ORDER = order_of("filter")


def folder(path):
    return path.relative_to(ROOT).parts[0]


def homes_at(door):
    """Return for each name at the filter's door the module that it is from."""
    nodes = [node for node in ast.parse(door.read_text()).body if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module for node in nodes for alias in node.names}


HOMES = homes_at(NAMES["filter"])


@cache
def imports(path):
    """Return the full names that a module imports, with `from a import b` as a and, when b is a module of ours, a.b.

    What is imported at the filter's door counts as imported from where it is at home.
    """
    names = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            if node.module == "filter":
                names |= {HOMES.get(alias.name, f"filter.{alias.name}") for alias in node.names}
                continue
            modules = {f"{node.module}.{alias.name}" for alias in node.names}
            ours = {name for name in modules if name in NAMES}
            names |= ours or {node.module}
    return frozenset(names)


def top(name):
    return name.split(".")[0]


def of(name):
    return [pytest.param(path, id=str(path.relative_to(ROOT))) for path in MODULES if folder(path) == name]


def everyone():
    return [pytest.param(path, id=str(path.relative_to(ROOT))) for path in MODULES]


def test_there_are_modules_to_look_at():
    assert {folder(path) for path in MODULES} == set(FOLDERS)


def test_every_module_of_the_filter_has_its_place_in_the_order():
    modules = [name for name, path in NAMES.items() if folder(path) == "filter" and path.stem != "__init__"]
    assert sorted(ORDER) == sorted(modules)


@pytest.mark.parametrize("path", of("filter"))
def test_the_filter_stands_alone(path):
    allowed = {"filter", "numpy", "scipy", *PLAIN} | AND.get(name_of(path), set())
    assert {top(name) for name in imports(path)} <= allowed
    assert not any(name.startswith("numpy.random") for name in imports(path))


@pytest.mark.parametrize("path", of("filter"))
def test_the_filter_does_not_go_through_its_own_door(path):
    froms = [node.module for node in nodes_of(path) if isinstance(node, ast.ImportFrom)]
    assert "filter" not in froms


@pytest.mark.parametrize("path", of("filter"))
def test_the_filter_has_no_files_and_no_randomness(path):
    for node in nodes_of(path):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in ("open", "print", "input", "exec", "eval", "__import__")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np":
            assert node.attr not in ("random", "save", "savez", "load", "savetxt", "loadtxt")


@pytest.mark.parametrize("name", ORDER)
def test_the_filter_reads_in_one_order(name):
    before = set(ORDER[: ORDER.index(name)])
    assert {other for other in imports(NAMES[name]) if top(other) == "filter"} <= before


def is_compiled(node):
    return isinstance(node, ast.FunctionDef) and any(ast.unparse(each) == "compiled" for each in node.decorator_list)


def compiled_functions():
    """Return the compiled functions of the filter, by module and name."""
    trees = {name: nodes_of(NAMES[name])[0] for name in ORDER}
    return {(name, node.name): node for name, tree in trees.items() for node in tree.body if is_compiled(node)}


COMPILED = compiled_functions()


@cache
def called_from_python():
    """Return those of them that a function calls, or hands on, that is not compiled itself."""
    called = set()
    for name, path in NAMES.items():
        nodes, known = nodes_of(path), {function: (home, function) for home, function in COMPILED if home == name}
        for node in (node for node in nodes if isinstance(node, ast.ImportFrom)):
            known |= {alias.asname or alias.name: (node.module, alias.name) for alias in node.names}
        known = {word: whole for word, whole in known.items() if whole in COMPILED}
        python = [node for node in nodes[0].body if known and not is_compiled(node)]
        called |= {known.get(leaf.id) for node in python for leaf in ast.walk(node) if isinstance(leaf, ast.Name)}
    return sorted(called & set(COMPILED))


def is_harmless(returned):
    """Return whether numba hands it out without a call of Python: numbers, tuples of them; of one new array it survives."""
    if isinstance(returned, ast.Subscript) and ast.unparse(returned.value) == "tuple":
        parts = returned.slice.elts if isinstance(returned.slice, ast.Tuple) else [returned.slice]
        return all(ast.unparse(part) not in ONE_ARRAY and is_harmless(part) for part in parts)
    return ast.unparse(returned) in NUMBERS | ONE_ARRAY


@pytest.mark.parametrize(("name", "function"), called_from_python())
def test_compiled_functions_return_nothing_to_python_that_an_interrupt_turns_into_a_crash(name, function):
    node = COMPILED[name, function]
    assert is_harmless(node.returns), ast.unparse(node.returns)
    assert not any("list" in ast.unparse(each.annotation) for each in node.args.args)


def test_it_is_noticed_what_python_calls():
    assert ("filter.geometry.convex", "clip_box") in called_from_python()
    assert ("filter.geometry.convex", "span_of") not in called_from_python()
    harmful = ["tuple[Array, float]", "tuple[Array, Array]", "tuple[int, tuple[Mask, bool]]", "Sheet", "list[float]"]
    assert not any(is_harmless(ast.parse(each, mode="eval").body) for each in harmful)
    assert all(is_harmless(ast.parse(each, mode="eval").body) for each in ("tuple[int, tuple[float, bool]]", "Array", "None"))


@pytest.mark.parametrize("path", of("sim"))
def test_the_simulator_knows_the_filters_records_only(path):
    ours = {name for name in imports(path) if top(name) in FOLDERS}
    assert {name for name in ours if top(name) == "filter"} <= RECORDS
    assert {top(name) for name in ours} <= {"filter", "sim", "models"}


@pytest.mark.parametrize("path", of("models"))
def test_models_know_nobody(path):
    assert not {name for name in imports(path) if top(name) in FOLDERS and top(name) != "models"}


@pytest.mark.parametrize("path", everyone())
def test_solvers_physics_recording_and_decoding_are_in_their_places(path):
    names = {top(name) for name in imports(path)}
    name = name_of(path)
    assert name == "filter.linear.solvers" or not names & {"piqp", "qpsolvers", "highspy"}
    assert folder(path) == "sim" or "mujoco" not in names
    shown = {f"experiments.show.{each}" for each in ("recording", "blueprint", "columns", "onlooker")}
    assert name in shown or "rerun" not in names
    assert name in ("experiments.logs.reading.fast", "experiments.logs.reading.typed") or "msgspec" not in names
    assert name in ("experiments.recorded.bags", "experiments.minute.recorded") or "rosbags" not in names
    assert name == "experiments.own_data.units" or "pyproj" not in names


@pytest.mark.parametrize("path", [*everyone(), *(pytest.param(path, id=path.name) for path in TESTS)])
def test_nobody_hides_the_builtin_filter(path):
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            assert not any(top(alias.name) == "filter" and alias.asname is None for alias in node.names)


def test_there_is_no_package_of_tests_that_hides_what_is_tested():
    assert not any((ROOT / "tests" / name).exists() for name in FOLDERS)
    assert not list((ROOT / "tests").rglob("__init__.py"))


@pytest.mark.parametrize("path", of("filter"))
def test_no_module_of_the_filter_is_too_long(path):
    assert len(path.read_text().splitlines()) <= LONGEST


@pytest.mark.parametrize("place", ["filter", "sim", "models", "experiments", "tests"])
def test_no_folder_is_too_full(place):
    folders = {path.parent for path in (ROOT / place).rglob("*.py")} - {ROOT / "experiments"}
    assert {str(each): len(list(each.glob("*.py"))) for each in folders if len(list(each.glob("*.py"))) > FULLEST} == {}


@pytest.mark.parametrize("path", sorted((ROOT / "experiments").glob("[!_]*.py")), ids=lambda path: path.stem)
def test_experiments_are_commands_and_their_parts_are_in_folders(path):
    assert "\ndef main(" in path.read_text()


def test_types_and_constants_of_the_filter_have_one_home_each():
    homes = {}
    for path in sorted((ROOT / "filter").rglob("*.py")):
        for node in ast.parse(path.read_text()).body:
            names = [node.name] if isinstance(node, ast.ClassDef) else []
            if isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = [
                    each.id for each in targets if isinstance(each, ast.Name) and re.fullmatch(r"[A-Z][A-Z0-9_]+", each.id)
                ]
            for name in names:
                homes.setdefault(name, set()).add(path.relative_to(ROOT).as_posix())
    assert {name: places for name, places in homes.items() if len(places) > 1} == {}
