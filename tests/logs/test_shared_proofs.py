"""A proof that several processes share has the verdict, the words and the counts of a single one."""

import shutil
import sys
from collections import Counter
from pathlib import Path

import pytest
from helpers.proved.doubts import lied, proved
from helpers.proved.runs import forge, lines_of, moved, run_of

from experiments import prove
from experiments.proof.reading import Broken
from experiments.proof.share import Share, shared, whose
from experiments.prove import ALTERNATIVES, HEADINGS, LINES, REGIONS
from filter import Bearing

MANY = 3


def outcome(path, number=0, processes=1):
    """Return what one of some processes says: at which part it stops and why, or all that it counts."""
    share = Share(number, processes)
    try:
        _, links = proved(path, share)
    except Broken as error:
        return share.part, str(error), Counter()
    return share.part, "", links


def check_refused_alike(path):
    """Check that a run is refused by the process that the forged part is for as by a single one; return who that is."""
    (part, why, _), several = outcome(path), [outcome(path, number, MANY) for number in range(MANY)]
    least = min(place for place, reason, _ in several if reason)
    assert why
    assert (least, several[whose(least, MANY)][1]) == (part, why)
    return whose(least, MANY)


def test_shares_count_what_one_counts_and_refuse_what_one_refuses(tmp_path):
    doubtful = tmp_path / "doubtful"
    doubtful.mkdir()
    lied(doubtful, Bearing)
    (parts, _, links), several = outcome(doubtful), [outcome(doubtful, number, 2) for number in range(2)]
    assert sum((each for *_, each in several), Counter()) == links
    assert all(each["certificates"] > links["certificates"] / 4 for *_, each in several)
    assert {part for part, *_ in several} == {parts}
    copy = Path(shutil.copytree(doubtful, tmp_path / "copy"))
    forge(copy, ALTERNATIVES, lambda records: lower(records[len(records) // 4]["instants"][-1]["lines"]))
    check_refused_alike(copy)


def lower(lines, by=-0.01):
    lines[-1]["offset"] = moved(lines[-1]["offset"], by)


def narrow(record):
    record["bound"][0] = moved(record["bound"][0], -0.05)


def enlarge(record):
    record["regions"][1]["area"] = moved(record["regions"][1]["area"], 0.1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run_of(tmp_path_factory.mktemp("shared"), steps=3)


def test_what_is_forged_is_refused_whoever_it_is_for(folder, tmp_path):
    refused_by = set()
    for name, change in ((REGIONS, enlarge), (LINES, lambda line: lower([line])), (HEADINGS, narrow)):
        for k in (0, -1):
            copy = Path(shutil.copytree(folder, tmp_path / f"{name}{k}"))
            forge(copy, name, lambda records, k=k, change=change: change(records[k]))
            refused_by.add(check_refused_alike(copy))
    assert len(refused_by) > 1


def verdict(folder, capsys, *options):
    return prove.main([str(folder), *options]), capsys.readouterr().out


def test_processes_say_what_one_says(folder, tmp_path, capsys):
    assert verdict(folder, capsys, "--workers", "2") == verdict(folder, capsys)
    copy, lines = Path(shutil.copytree(folder, tmp_path / "copy")), lines_of(folder)
    forge(copy, LINES, lambda records: records[len(lines) // 2].update(offset=moved(lines[len(lines) // 2]["offset"], -0.1)))
    code, told = verdict(copy, capsys, "--workers", "2")
    assert code == 1
    assert (code, told) == verdict(copy, capsys)


def test_a_process_that_is_ended_is_no_proof():
    with pytest.raises(ChildProcessError):
        shared(sys.exit, 2)


@pytest.mark.parametrize("count", ["0", "-1", "two"])
def test_there_is_a_process_at_least(folder, count):
    with pytest.raises(SystemExit, match="2"):
        prove.main([str(folder), "--workers", count])
