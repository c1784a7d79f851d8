"""Compiled functions do what they say, wherever they can be kept, and whoever interrupts their first call."""

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from filter import compiled as module
from filter.compiled import compiled
from filter.geometry.convex import area_of

ROOT = Path(__file__).parents[2]
SOURCE = """
from filter.compiled import compiled

@compiled
def inner(x):
    return x + 1

@compiled
def doubled(x):
    return 2 * inner(x) - 2
"""
# Every first call is made in a process of its own, that loads the function and is interrupted on the way.
FIRST_CALLS = """
import collections, os, signal, sys, time
import numpy as np
from kept import doubled, inner

inner(1.0)  # the compiler is ready
class Interrupt(BaseException): pass
def handler(*_): raise Interrupt

def child(delay):
    signal.signal(signal.SIGALRM, handler)
    said = "other"
    try:
        signal.setitimer(signal.ITIMER_REAL, delay)
        doubled(np.arange(3.0))
        said = "done"
        signal.setitimer(signal.ITIMER_REAL, 0)
    except Interrupt:
        said = "interrupted"
    signal.setitimer(signal.ITIMER_REAL, 0)
    print(said, doubled(np.arange(3.0)).tolist() == [0.0, 2.0, 4.0], flush=True)

for k in range(int(sys.argv[1])):
    pid = os.fork()
    if not pid:
        try:
            child(1e-4 + 2e-2 * (37 * k % 101) / 101)
        finally:
            os._exit(0)
    if os.waitpid(pid, 0)[1]:
        print("crashed", flush=True)
"""


@compiled
def doubled(x):
    return 2 * x


@pytest.fixture
def elsewhere(tmp_path):
    """A folder with a module of compiled functions, and how to run a program there that keeps them in a folder of its own."""
    (tmp_path / "kept.py").write_text(SOURCE)

    def run(text, *arguments, **environment):
        (tmp_path / "program.py").write_text(text)
        there = {"PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, str(tmp_path / "program.py"), *arguments]
        surroundings = os.environ | there | environment
        return subprocess.run(command, env=surroundings, capture_output=True, text=True, timeout=300, check=False)

    return run


def test_a_compiled_function_is_the_function():
    assert doubled(21) == 42
    assert doubled.py_func(21) == 42


def test_the_callers_settings_stay_as_they_were(monkeypatch):
    monkeypatch.setattr(module.SETTINGS, "CACHE_DIR", "elsewhere")
    compiled(lambda: 0)
    assert module.SETTINGS.CACHE_DIR == "elsewhere"
    assert next(module._folders()) == Path("elsewhere").absolute()


def test_what_is_compiled_is_kept_under_the_version_of_the_whole_filter(monkeypatch, tmp_path):
    shutil.copytree(module.FOLDER, tmp_path / "filter", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(module, "FOLDER", tmp_path / "filter")
    monkeypatch.setattr(module, "_folders", lambda: iter([tmp_path]))
    same = Path(module._place()).name
    assert same == Path(module.PLACE).name
    assert module.PLACE in str(area_of.stats.cache_path)
    for name in ("team.py", "geometry/convex.py"):
        path = tmp_path / "filter" / name
        path.write_text(path.read_text() + "\n")
        assert Path(module._place()).name != same
        same = Path(module._place()).name
    monkeypatch.setattr(module.numba, "__version__", "another")
    assert Path(module._place()).name != same


def test_the_first_folder_that_can_be_written_is_taken_and_else_none(monkeypatch, tmp_path):
    file = tmp_path / "file"
    file.touch()
    monkeypatch.setattr(module, "_folders", lambda: iter([Path("/proc/nope"), file, tmp_path / "one", tmp_path / "other"]))
    assert Path(module._place()).parent == tmp_path / "one"
    monkeypatch.setattr(module, "_folders", lambda: iter([Path("/proc/nope"), file]))
    assert module._place() is None


def test_without_a_folder_a_function_works_as_well(monkeypatch):
    monkeypatch.setattr(module, "PLACE", None)
    assert compiled(lambda x: x + 1)(1) == 2


def test_a_temporary_folder_is_nobody_elses(monkeypatch, tmp_path):
    monkeypatch.setattr(module.tempfile, "gettempdir", lambda: str(tmp_path))
    mine = tmp_path / f"corral-{os.getuid()}"
    assert mine in list(module._folders())
    assert mine.stat().st_mode & 0o777 == 0o700
    mine.chmod(0o770)
    assert mine not in list(module._folders())
    mine.rmdir()
    mine.symlink_to(tmp_path / "planted")
    (tmp_path / "planted").mkdir(mode=0o700)
    assert mine not in list(module._folders())
    mine.unlink()
    mine.mkdir(mode=0o700)
    monkeypatch.setattr(module.os, "getuid", lambda: tmp_path.stat().st_uid + 1)
    mine.rename(tmp_path / f"corral-{module.os.getuid()}")
    assert tmp_path / f"corral-{module.os.getuid()}" not in list(module._folders())


def test_there_is_always_a_folder_without_a_home(monkeypatch):
    monkeypatch.setenv("HOME", "nowhere")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert all(folder.is_absolute() for folder in module._folders())


def test_one_line_says_that_something_is_compiled_and_none_that_it_is_loaded(elsewhere):
    text = "from kept import doubled\nprint(doubled(1), doubled(1.5))"
    first, second = elsewhere(text), elsewhere(text)
    assert first.stdout == second.stdout == "2 3.0\n"
    (line,) = first.stderr.splitlines()
    assert "compiling" in line
    assert "/cache/corral-" in line
    assert second.stderr == ""


def test_a_function_compiles_with_nobody_to_tell_it_to(elsewhere):
    assert elsewhere("import sys\nsys.stderr.close()\nfrom kept import doubled\nprint(doubled(1))").stdout == "2\n"


def test_what_is_cut_off_on_disk_is_made_anew(elsewhere, tmp_path):
    text = "from kept import doubled, inner\nprint(inner(1), doubled(1))"
    assert elsewhere(text).returncode == 0
    cut = [path for form in ("kept.inner*.nbi", "kept.doubled*.nbc") for path in tmp_path.rglob(form)]
    assert len(cut) == 2
    for path in cut:
        path.write_bytes(path.read_bytes()[:20])
    broken = elsewhere(text)
    assert (broken.stdout, broken.stderr.count("\n")) == ("2 2\n", 1)
    assert elsewhere(text).stderr == ""  # mended


def test_a_full_disk_keeps_nothing_and_stops_nobody():
    class Full:
        cache_path = "nowhere"

        def save_overload(self, *_):
            raise OSError(errno.ENOSPC, "No space left on device")

    module._Kept(Full()).save_overload((), None)


def test_a_form_for_other_arguments_is_not_taken():
    class Mixed:
        cache_path = "nowhere"

        def _load_overload(self, *_):
            return area_of.overloads[area_of.signatures[0]]

    area_of(np.zeros((3, 2)))
    assert module._Kept(Mixed()).load_overload(area_of.signatures[0], None) is not None
    assert module._Kept(Mixed()).load_overload((), None) is None


def test_an_interrupted_first_call_is_interrupted_and_the_next_one_works(elsewhere):
    """Numba's own loader crashes or is broken for good in one of fifty."""
    elsewhere("import numpy as np\nfrom kept import doubled, inner\ninner(1.0), doubled(np.arange(3.0))")
    run = elsewhere(FIRST_CALLS, "100")
    said = run.stdout.splitlines()
    assert len(said) == 100
    assert set(said) <= {"interrupted True", "done True"}
    assert said.count("interrupted True") > 20


def test_a_read_only_checkout_without_a_home_works(elsewhere, tmp_path):
    program = tmp_path / "program.py"
    elsewhere("import filter\nfrom filter import compiled\nfrom kept import doubled\nprint(doubled(1), compiled.PLACE)")
    command = f"mount --bind {ROOT} {ROOT} && mount -o remount,ro,bind {ROOT} && exec {sys.executable} {program}"
    nowhere = {"HOME": "/proc/nope", "XDG_CACHE_HOME": "/proc/nope", "PYTHONPATH": str(ROOT), "TMPDIR": str(tmp_path)}
    surroundings = {"PATH": os.environ["PATH"]} | nowhere
    run = subprocess.run(["unshare", "-m", "sh", "-c", command], env=surroundings, capture_output=True, text=True, check=False)
    if "unshare" in run.stderr or "mount" in run.stderr:
        pytest.skip("no mount namespaces here")
    assert run.returncode == 0, run.stderr
    assert run.stdout.split()[0] == "2"
    assert Path(run.stdout.split()[1]).parent == tmp_path / f"corral-{os.getuid()}"
