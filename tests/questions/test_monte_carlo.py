import json
import os

import pytest
from helpers import tasks

from experiments.sweep import executors
from experiments.sweep.executors import NoCluster, cores, executor
from experiments.sweep.results import Results, WorkerLost, carry_out
from filter.errors import InvalidInput

OPTIONS = {"robots": 3, "duration": 2.0}


def opened(folder, resume=False, options=OPTIONS):
    results = Results(folder, options)
    results.open(resume)
    return results


def cases_of(count):
    return {f"run-{k}": k for k in range(count)}


def test_every_case_is_computed_and_kept(tmp_path):
    results = opened(tmp_path)
    with executor(2) as pool:
        names = list(carry_out(results, pool, tasks.square, cases_of(5)))
    assert sorted(names) == sorted(cases_of(5))
    assert [results.read(f"run-{k}") for k in range(5)] == [{"square": k * k} for k in range(5)]


def test_a_sweep_that_is_resumed_computes_only_what_is_missing(tmp_path):
    marks = tmp_path / "marks"
    marks.mkdir()
    cases = {f"run-{k}": (k, str(marks)) for k in range(4)}
    results = opened(tmp_path / "out")
    for k in (1, 2):
        results.write(f"run-{k}", {"square": k * k})
    again = opened(tmp_path / "out", resume=True)
    with executor(1) as pool:
        names = list(carry_out(again, pool, tasks.noted, cases))
    assert names[:2] == ["run-1", "run-2"]
    assert sorted(names) == sorted(cases)
    assert {mark.name: mark.read_text() for mark in marks.iterdir()} == {"0": "x", "3": "x"}


def test_a_result_that_is_cut_off_is_computed_again(tmp_path):
    results = opened(tmp_path)
    results.write("run-0", {"square": 0})
    path = tmp_path / "runs" / "run-0.json"
    path.write_text(path.read_text()[:-4])
    assert results.read("run-0") is None
    with executor(1) as pool:
        list(carry_out(results, pool, tasks.square, {"run-0": 7}))
    assert results.read("run-0") == {"square": 49}


def test_a_half_written_result_has_no_name_to_be_read_by(tmp_path, monkeypatch):
    results = opened(tmp_path)

    def killed(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", killed)
    with pytest.raises(KeyboardInterrupt):
        results.write("run-0", {"square": 0})
    monkeypatch.undo()
    assert results.read("run-0") is None
    assert list((tmp_path / "runs").glob("*.json")) == []
    opened(tmp_path, resume=True)
    assert list((tmp_path / "runs").iterdir()) == []


def test_results_are_never_overwritten_without_being_asked_to_resume(tmp_path):
    opened(tmp_path).write("run-0", {"square": 0})
    with pytest.raises(InvalidInput, match="--resume to go on"):
        opened(tmp_path)
    assert opened(tmp_path, resume=True).read("run-0") == {"square": 0}


def test_results_of_other_options_are_never_mixed(tmp_path):
    opened(tmp_path).write("run-0", {"square": 0})
    with pytest.raises(InvalidInput, match=r"duration 3\.0.*came duration 2\.0"):
        opened(tmp_path, resume=True, options=OPTIONS | {"duration": 3.0})
    (tmp_path / "options.json").unlink()
    with pytest.raises(InvalidInput, match="same options"):
        opened(tmp_path, resume=True)


def test_a_folder_without_results_can_be_used_with_any_options(tmp_path):
    opened(tmp_path)
    opened(tmp_path, options=OPTIONS | {"duration": 3.0})
    assert json.loads((tmp_path / "options.json").read_text())["duration"] == 3.0


def test_a_folder_that_cannot_be_made_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InvalidInput, match="folder that can be written to"):
        opened(tmp_path / "file" / "out")


def test_a_task_that_fails_leaves_what_is_finished(tmp_path):
    results = opened(tmp_path)
    with executor(1) as pool, pytest.raises(ValueError, match="three"):
        list(carry_out(results, pool, tasks.fails_at_three, cases_of(6)))
    assert [results.read(f"run-{k}") for k in range(4)] == [{"square": 0}, {"square": 1}, {"square": 2}, None]


def test_a_worker_that_dies_is_told(tmp_path):
    with executor(1) as pool, pytest.raises(WorkerLost, match="--resume"):
        list(carry_out(opened(tmp_path), pool, tasks.dies, cases_of(2)))


def test_a_worker_computes_with_one_thread_and_this_process_is_left_alone(tmp_path):
    before = dict(os.environ)
    results = opened(tmp_path)
    with executor(1) as pool:
        list(carry_out(results, pool, tasks.threads, cases_of(1)))
    assert results.read("run-0") == {"threads": "1"}
    assert dict(os.environ) == before


def test_all_cores_are_used_if_nothing_is_said():
    with executor() as pool:
        assert pool._max_workers == cores() >= 1


@pytest.mark.parametrize("workers", [0, -1])
def test_fewer_than_one_worker_is_refused(workers):
    with pytest.raises(InvalidInput, match="workers"), executor(workers):
        pass


def test_workers_and_a_scheduler_exclude_one_another():
    with pytest.raises(InvalidInput, match="scheduler"), executor(2, "tcp://127.0.0.1:1"):
        pass


def test_a_missing_dask_is_told_with_what_to_install(monkeypatch):
    def missing(_):
        raise ImportError

    monkeypatch.setattr(executors, "import_module", missing)
    with pytest.raises(NoCluster, match=r"corral\[cluster\]"), executor(scheduler="tcp://127.0.0.1:1"):
        pass


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x"])
def test_a_scheduler_that_does_not_answer_is_told(monkeypatch, address):
    monkeypatch.setattr(executors, "PATIENCE", "1s")
    with pytest.raises(NoCluster, match="no Dask scheduler answers"), executor(scheduler=address):
        pass
