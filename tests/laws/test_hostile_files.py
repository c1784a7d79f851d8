"""Files that are damaged, or made to break whoever reads them: a clear line each, no traceback, and nothing is proved."""

import gzip
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.runs import FILES, lines_of, rewritten, run_of

from experiments import prove
from experiments.prove import HEADINGS, LINES, REGIONS, SUMMARY

ROOT = Path(__file__).parents[2]
LOG, POSES = "log.jsonl", "trajectories/r1_filter.tum"
EVERY = (*FILES, LOG, SUMMARY, POSES)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("hostile"), steps=4)


@pytest.fixture
def copy(folder, tmp_path):
    return Path(shutil.copytree(folder, tmp_path / "copy"))


def refusal(folder, capsys):
    """Return the one line that says why nothing is proved."""
    assert prove.main([str(folder)]) == 1
    told = capsys.readouterr().out
    assert told.startswith("not proved: ")
    assert told.count("\n") == 1
    assert len(told) < 1000
    return told


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.999])
def test_a_file_that_is_cut_off_is_named(copy, name, share, capsys):
    whole = (copy / name).read_bytes()
    (copy / name).write_bytes(whole[: int(share * len(whole))])
    assert Path(name).name in refusal(copy, capsys)


GZIP = {
    "no gzip": lambda packed: b"no gzip",
    "another byte": lambda packed: (
        packed[: len(packed) // 2] + bytes([packed[len(packed) // 2] ^ 1]) + packed[len(packed) // 2 + 1 :]
    ),
    "a tail": lambda packed: packed + b"and more",
    "twice": lambda packed: packed + packed,
    "no UTF-8": lambda packed: gzip.compress(b"\xff\xfe" + gzip.decompress(packed)),
    "zeros": lambda packed: bytes(1000),
    "a line without end": lambda packed: gzip.compress(b" " * (1 << 25)),
    "no end of a line": lambda packed: gzip.compress(gzip.decompress(packed)[:-1]),
}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("how", GZIP)
def test_a_file_that_is_no_gzip_of_lines_is_named(copy, name, how, capsys):
    (copy / name).write_bytes(GZIP[how]((copy / name).read_bytes()))
    assert name in refusal(copy, capsys)


TEXTS = {
    "NaN": ("NaN", "NaN is no number"),
    "Infinity": ("-Infinity", "-Infinity is no number"),
    "a huge float": ("1e999", ""),
    "a huge integer": ("9" * 400, ""),
    "digits without end": ("9" * 100_000, ""),
    "deep": ("[" * 100_000 + "]" * 100_000, "nested too deep"),
    "rather deep": ("[" * 900 + "]" * 900, ""),
    "a long text": ('"' + "x" * 100_000 + '"', ""),
    "deep objects": ('{"a":' * 100_000 + "1" + "}" * 100_000, "nested too deep"),
    "a name twice": ('{"a": 1, "a": 2}', "a name stands twice"),
    "no JSON": ("x", "Expecting value"),
    "null": ("null", ""),
    "true": ("true", ""),
    "text": ('"0x1p+0"', ""),
    "a list": ("[]", ""),
    "an object": ("{}", ""),
    "minus one": ("-1", ""),
    "a fraction": ("0.5", ""),
}
PLACES = {  # where the text is put instead of what is there
    "a time": (LINES, '"t": "'),
    "an offset": (LINES, '"offset": "'),
    "a robot": (LINES, '"robot": '),
    "rows": (LINES, '"rows": ['),
    "a box": (LINES, '"lower": {'),
    "a version": (HEADINGS, '"version": '),
    "a bound": (HEADINGS, '"bound": ['),
    "regions": (REGIONS, '"regions": ['),
    "an area": (REGIONS, '"area": "'),
    "robots": (LOG, '"robots": '),
    "an arena": (LOG, '"arena": ['),
    "who": (LOG, '"robot": ['),
    "a count": (SUMMARY, '"checks": '),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("text", TEXTS)
def test_a_value_of_another_kind_is_refused(copy, place, text, capsys):
    (name, before), (value, why) = PLACES[place], TEXTS[text]
    path = copy / name
    whole = (gzip.decompress(path.read_bytes()) if name.endswith(".gz") else path.read_bytes()).decode()
    at = whole.index(before) + len(before) - (before[-1] in '"[{')
    _, end = json.JSONDecoder().raw_decode(whole[at:])
    changed = (whole[:at] + value + whole[at + end :]).encode()
    path.write_bytes(gzip.compress(changed, 1) if name.endswith(".gz") else changed)
    told = refusal(copy, capsys)
    assert name in told
    assert why in told


@pytest.mark.parametrize("name", [*FILES, LOG])
@pytest.mark.parametrize("wrong", ["{}", "[1]", '"x"', "3", "null", '{"t": "0x0p+0", "version": 3}', '{"record": "frame"}'])
def test_a_line_of_another_form_is_refused_with_its_number(copy, name, wrong, capsys):
    lines = lines_of(copy, name)
    lines.insert(4, json.loads(wrong))
    rewritten(copy, lines, name)
    assert f"{name}, line 5" in refusal(copy, capsys)


@pytest.mark.parametrize("name", FILES)
def test_another_version_is_refused(copy, name, capsys):
    lines = [{**line, "version": 1} for line in lines_of(copy, name)]
    rewritten(copy, lines, name)
    assert f"{name}, line 1: version 1, where version 3 is read" in refusal(copy, capsys)


def places_in(value, path=()):
    """Yield the way to every value within a value."""
    yield path
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from places_in(value[key], (*path, key))


JUNK = (
    None,
    True,
    -1,
    10**400,
    1e308,
    "",
    "x",
    "0x1p+1023",
    "-0x1p+1023",
    "nan",
    "inf",
    [],
    {},
    [[]],
    {"0": []},
    ["0x0p+0"] * 3,
)


@pytest.mark.parametrize("seed", range(40))
def test_whatever_is_in_the_files_there_is_a_verdict_in_words(copy, seed, capsys):
    rng = np.random.default_rng(seed)
    name = [*FILES, LOG][seed % 4]
    lines = lines_of(copy, name)
    line = lines[rng.integers(len(lines) if seed % 3 else min(len(lines), 3))]
    way = list(places_in(line))[1:]
    *path, last = way[rng.integers(len(way))]
    inner = line
    for key in path:
        inner = inner[key]
    inner[last] = JUNK[rng.integers(len(JUNK))]
    rewritten(copy, lines, name)
    assert prove.main([str(copy)]) in (0, 1)
    every = len(lines_of(copy)) + sum(len(record["lines"]) for record in lines_of(copy, HEADINGS))
    verdict = capsys.readouterr().out.splitlines()[-1]
    assert verdict.startswith("not proved: ") or verdict == f"{every} certificates proved, 0 failed"


def test_a_folder_in_a_files_place_is_bad_input(copy, capsys):
    (copy / LINES).unlink()
    (copy / LINES).mkdir()
    assert prove.main([str(copy)]) == 2
    assert capsys.readouterr().err.strip().endswith("Is a directory")


def test_no_traceback_comes_from_another_process(copy):
    rewritten(copy, [], LINES)
    command = [sys.executable, "-m", "experiments.prove", str(copy)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert (
        done.stdout == "not proved: certificates.jsonl.gz: there is nothing for the log's frame at t = 0.0 s: the file ends\n"
    )
    assert "Traceback" not in done.stderr
