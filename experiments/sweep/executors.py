"""Where a sweep computes: on the cores of this machine, or on a Dask cluster; a `concurrent.futures` executor either way."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module

from experiments.sweep.own_process import end_with_parent, one_thread
from filter import CorralError, InvalidInput

PATIENCE = "10s"  # that a scheduler may take to answer


class NoCluster(CorralError):
    """A cluster cannot be used; everything works without."""


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def executor(workers: int | None = None, scheduler: str | None = None) -> Iterator[Executor]:
    """Lend an executor; work that has not begun is dropped when its user fails.

    Args:
        workers: How many processes on this machine; None for one on each core.
        scheduler: Address of a Dask scheduler to compute on instead, or None.

    Raises:
        InvalidInput: The number of workers is below 1, or comes together with a scheduler.
        NoCluster: Dask is not installed, or the scheduler does not answer.
    """
    if scheduler is not None and workers is not None:
        raise InvalidInput("either workers on this machine or a scheduler, which has its own", "both")
    lent = _local(workers) if scheduler is None else _cluster(scheduler)
    with lent as pool:
        yield pool


@contextmanager
def _local(workers: int | None) -> Iterator[Executor]:
    count = cores() if workers is None else workers
    if count < 1:
        raise InvalidInput("number of workers: a whole number from 1 on", repr(workers))
    with one_thread():  # inherited by the workers, as many as cores
        pool = ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"), initializer=end_with_parent)
        try:
            yield pool
        finally:
            pool.shutdown(cancel_futures=True)


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        dask = import_module("distributed")
    except ImportError:
        raise NoCluster("no Dask here for --scheduler: install it with pip install 'corral[cluster]'") from None
    try:
        client = dask.Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise NoCluster(f"no Dask scheduler answers at {address}: {error}") from None
    try:
        with client, client.get_executor(pure=False, retries=2) as pool:
            yield pool
    except dask.KilledWorker as error:
        raise NoCluster(f"workers of {address} died again and again: {error}; what is finished is kept") from None
