"""Do the tests catch every wrong sign? Flips each sign in sectors, rows and motions, one at a time, and runs the tests on that.

    python tests/house/mutate.py

A sign is a minus in front of something, a plus or minus between two, or a comparison. The project is copied to a temporary
folder, nothing here is touched, nothing is compiled. Exit code 0 if every flipped sign is caught, 1 if one survives.
"""

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[2]
SENSING = ("rows", "headings", "motion", "since", "arms")
MODULES = (
    "filter/geometry/sector.py",
    *(f"filter/sensing/{name}.py" for name in SENSING),
    "filter/joined.py",
    "filter/motions.py",
)
# The nearest tests first: they catch most, and quickly.
TESTS = (
    ("tests/geometry/test_sector.py", *(f"tests/sensing/test_{name}.py" for name in SENSING)),
    ("tests/hall/test_motions.py", "tests/hall/test_stream.py", "tests/records"),
    ("tests/laws/test_signs.py", "tests/laws/test_minkowski.py"),
    ("tests/sets/test_set_membership.py", "tests/laws/test_laws.py"),
)
LIMIT = 1800  # [s]; a mutant that takes longer is caught
FLIPPED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Lt: ast.Gt,
    ast.Gt: ast.Lt,
    ast.LtE: ast.GtE,
    ast.GtE: ast.LtE,
}


class Flip(ast.NodeTransformer):
    """Flips the sign at one place; counts the places when that is -1."""

    def __init__(self, place):
        self.place, self.count, self.line = place, 0, 0

    def _here(self, node):
        self.count += 1
        if self.count - 1 == self.place:
            self.line = node.lineno
            return True
        return False

    def visit_UnaryOp(self, node):
        self.generic_visit(node)
        return node.operand if isinstance(node.op, ast.USub) and self._here(node) else node

    def visit_BinOp(self, node):
        self.generic_visit(node)
        if type(node.op) in FLIPPED and self._here(node):
            node.op = FLIPPED[type(node.op)]()
        return node

    def visit_Compare(self, node):
        self.generic_visit(node)
        if type(node.ops[0]) in FLIPPED and self._here(node):
            node.ops[0] = FLIPPED[type(node.ops[0])]()
        return node


def mutants(source):
    """Yield for every sign the source with that one flipped, the line, and that line's statement before and after."""
    counting = Flip(-1)
    counting.visit(ast.parse(source))
    plain = ast.unparse(ast.parse(source)).splitlines()
    for place in range(counting.count):
        flip = Flip(place)
        text = ast.unparse(flip.visit(ast.parse(source)))
        (changed,) = [(old.strip(), new.strip()) for old, new in zip(plain, text.splitlines(), strict=True) if old != new]
        yield text, flip.line, changed


def caught_by(module, text, folder):
    """Return the tests that fail on a mutant, or None."""
    copy = Path(tempfile.mkdtemp(dir=folder))
    for name in ("filter", "sim", "models", "experiments", "tests", "pyproject.toml", "README.md"):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, copy / name)
    (copy / module).write_text(text)
    try:
        for files in TESTS:
            command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *files]
            try:
                plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
                if subprocess.run(command, cwd=copy, env=plain, capture_output=True, timeout=LIMIT, check=False).returncode:
                    return files
            except subprocess.TimeoutExpired:
                return files
        return None
    finally:
        shutil.rmtree(copy)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=2, help="how many mutants at a time")
    jobs = parser.parse_args().jobs
    work = [(module, *mutant) for module in MODULES for mutant in mutants((ROOT / module).read_text())]
    survived = 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(jobs) as pool:
        unchanged = caught_by(MODULES[0], (ROOT / MODULES[0]).read_text(), folder)
        if unchanged:
            print(f"the tests fail without any change: {' '.join(unchanged)}")
            return 1
        verdicts = pool.map(lambda item: caught_by(item[0], item[1], folder), work)
        for (module, _, line, (old, new)), verdict in zip(work, verdicts, strict=True):
            survived += verdict is None
            said = "caught" if verdict else "SURVIVED"
            print(f"{said:9}{module}:{line}  {old}  ->  {new}", flush=True)
    print(f"{len(work)} signs flipped: {len(work) - survived} caught, {survived} survived")
    return int(survived > 0)


if __name__ == "__main__":
    sys.exit(main())
