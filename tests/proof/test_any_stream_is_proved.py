"""Whatever a log of version 2 says, in lock-step or as it comes: what the filter makes of it is proved."""

import gzip
import json
from codecs import BOM_UTF8
from collections import Counter

import numpy as np
import pytest
from helpers.proved.streams import NAMES, Team, as_it_comes, in_step, with_mates, written

from experiments import prove
from experiments.follow import main
from experiments.logs import LogReader
from experiments.logs.log import InvalidLog
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken
from experiments.prove import prove as links_of
from filter import Position

RUNS = [(in_step, 1), (in_step, 4), (as_it_comes, 3), (as_it_comes, 0), (as_it_comes, 1)]
MATES = (4, 1)  # where robots see how mates look, too


def followed(path, lines, *options):
    """Return the folder of a run on a log of some lines, with certificates."""
    log = written(path / "given.jsonl", lines)
    assert main([str(log), "--certificates", "--out", str(path / "run"), *options]) == 0
    return path / "run"


def drawn(make, seed):
    """Return the lines of a log."""
    rng = np.random.default_rng(seed)
    lines = make(team := Team(rng))
    return with_mates(lines, team, rng) if seed in MATES else lines


def silent(text):
    """Show nothing."""


def test_any_run_is_proved(tmp_path_factory):
    links = Counter()
    for make, seed in RUNS:
        path = tmp_path_factory.mktemp("run")
        folder = followed(path, drawn(make, seed), *(["--light"] if seed % 2 else []))
        links += links_of(folder, silent)
        told = json.loads((folder / "summary.json").read_text())
        assert told["checks"] > told["heading_checks"] > 0
        assert told["escapes"] == told["heading_escapes"] == 0
    assert links["rows of positions, from the log"] > 50
    assert links["rows of bearings, from the log"] > 50
    assert links["rows that are edges of an earlier step, moved"] > 50


def test_a_recording_calls_robots_by_their_names(tmp_path, capsys):
    folder = followed(tmp_path, in_step(Team(np.random.default_rng(1)))[:40], "--recording", "--light")
    assert prove.main([str(folder)]) == 0
    assert "regions of the recording" in capsys.readouterr().out
    assert {path.name for path in (folder / "trajectories").glob("*_filter.tum")} == {f"{name}_filter.tum" for name in NAMES}


@pytest.mark.parametrize("how", ["compressed", "with a mark", "as in Windows"])
def test_a_log_is_read_as_people_have_it(tmp_path, how):
    lines = as_it_comes(Team(np.random.default_rng(1)))
    whole = written(tmp_path / "log.jsonl", lines).read_bytes()
    frames = Log(tmp_path).frames
    forms = {
        "compressed": gzip.compress(whole),
        "with a mark": BOM_UTF8 + whole[:-1],
        "as in Windows": b"\r\n" + whole.replace(b"\n", b"\r\n"),
    }
    (tmp_path / "log.jsonl").write_bytes(forms[how])
    assert Log(tmp_path).frames == frames


@pytest.mark.parametrize("seed", range(12))
def test_its_frames_are_those_of_the_filter(tmp_path, seed):
    rng, make = np.random.default_rng(seed), in_step if seed % 4 == 0 else as_it_comes
    lines = make(team := Team(rng), *([1.6] if seed % 4 == 3 else []))
    path = written(tmp_path / "log.jsonl", with_mates(lines, team, rng))
    frames = []
    try:
        frames.extend(LogReader(path).frames())
    except InvalidLog as error:
        with pytest.raises(Broken, match=f"line {error.line}: "):
            Log(tmp_path)
        return
    for frame, exactly in zip(frames, Log(tmp_path).frames, strict=True):
        assert frame.time == exactly.time
        assert sum(len(record.robot) for record in frame.measurements if not isinstance(record, Position)) == sum(
            map(len, exactly.readings.values())
        )
