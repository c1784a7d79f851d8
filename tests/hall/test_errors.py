"""Errors carry data, and their messages name what was expected and what came."""

import copy
import importlib
import inspect
import pickle
import pkgutil
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import experiments
import filter as filter_package
import sim
from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder
from filter.linear.sources import Source

for package in (filter_package, experiments, sim):
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if module.name.split(".")[-1] != "__main__":
            importlib.import_module(module.name)

# Something for every parameter that an error of ours is made from, by its annotation.
SAMPLES = {
    str: "words",
    float: 1.5,
    int: 3,
    int | None: 2,
    Path: Path("folder/log.jsonl"),
    Any: [1.0, "anything"],
    object: "a reason",
    Sequence[Any]: [Source("range", 0.5, 1, 2), Source("compass", 0.5, 1)],
    NDArray[np.float64]: np.array([[1.0, 0.0], [0.0, 0.0]]),
}


def kinds(base=CorralError):
    return [base, *(kind for each in base.__subclasses__() for kind in kinds(each))]


def made(kind):
    if not any("__init__" in vars(each) for each in kind.__mro__ if issubclass(each, CorralError)):
        return kind("words")
    return kind(*(SAMPLES[each.annotation] for each in inspect.signature(kind, eval_str=True).parameters.values()))


def same(one, other):
    """Return whether two errors are of one kind, say the same and carry the same."""
    alike = type(one) is type(other) and str(one) == str(other) and vars(one).keys() == vars(other).keys()
    return alike and all(np.array_equal(value, vars(other)[name]) for name, value in vars(one).items())


def raise_(error):
    raise error


EVERY = pytest.mark.parametrize("kind", kinds(), ids=lambda kind: kind.__name__)


@EVERY
def test_every_error_can_be_copied_and_pickled_with_all_that_it_carries(kind):
    error = made(kind)
    error.add_note("a note")
    assert str(error)
    assert same(copy.deepcopy(error), error)
    assert same(copy.copy(error), error)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        assert same(pickle.loads(pickle.dumps(error, protocol)), error)


def test_every_error_crosses_a_process_pool_as_itself():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        for kind in kinds():
            with pytest.raises(kind) as raised:
                pool.submit(raise_, made(kind)).result()
            assert same(raised.value, made(kind))


@pytest.mark.parametrize(
    "error",
    [InvalidInput("a", "b"), OutOfOrder("a record", 1.0, 2.0), Inconsistent("at 1 s", ["a"])],
    ids=lambda e: type(e).__name__,
)
def test_every_error_has_one_base(error):
    assert isinstance(error, CorralError)


@pytest.mark.parametrize("error", [InvalidInput("a", "b"), OutOfOrder("a record", 1.0, 2.0)], ids=lambda e: type(e).__name__)
def test_an_error_of_input_is_a_value_error(error):
    assert isinstance(error, ValueError)


def test_invalid_input_names_what_was_expected_and_what_came():
    error = InvalidInput("a whole number", 1.5)
    assert (error.expected, error.came) == ("a whole number", 1.5)
    assert "a whole number" in str(error)
    assert "1.5" in str(error)


def test_a_late_record_is_told_that_it_is_late():
    error = OutOfOrder("compass", 1.0, 2.0)
    assert (error.time, error.belief_time) == (1.0, 2.0)
    assert "too late" in str(error)


def test_an_early_record_is_told_to_predict_first():
    assert "predict to 3.0 s first" in str(OutOfOrder("compass", 3.0, 2.0))


def test_inconsistent_names_every_source_in_its_order():
    error = Inconsistent("at 1 s", ["one", "two"])
    assert error.sources == ("one", "two")
    assert str(error).endswith("one; two")
