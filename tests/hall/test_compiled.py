"""Compiled functions do what they say, and are compiled anew when what they call has changed."""

from pathlib import Path

from filter import compiled as module
from filter.compiled import compiled
from filter.geometry.convex import area_of


@compiled
def doubled(x):
    return 2 * x


def test_a_compiled_function_is_the_function():
    assert doubled(21) == 42
    assert doubled.py_func(21) == 42


def test_the_callers_settings_stay_as_they_were(monkeypatch):
    monkeypatch.setattr(module.SETTINGS, "CACHE_DIR", "elsewhere")
    compiled(lambda: 0)
    assert module.SETTINGS.CACHE_DIR == "elsewhere"
    assert module._place().startswith("elsewhere")


def test_what_is_compiled_is_kept_under_the_version_of_all_that_is(monkeypatch, tmp_path):
    assert Path(module.PLACE).name == Path(module._place()).name
    for path in module.FOLDER.rglob("*.py"):
        copy = tmp_path / path.relative_to(module.FOLDER)
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(path.read_bytes())
    monkeypatch.setattr(module, "FOLDER", tmp_path)
    same = Path(module._place()).name
    assert same == Path(module.PLACE).name
    plain = tmp_path / "team.py"
    plain.write_text(plain.read_text() + "\n")
    assert Path(module._place()).name == same
    plane = tmp_path / "geometry" / "convex.py"
    plane.write_text(plane.read_text() + "\n")
    assert Path(module._place()).name != same
    assert module.PLACE in str(area_of.stats.cache_path)
