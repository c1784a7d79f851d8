"""Tasks for sweeps: processes that are spawned import them from here."""

import os
import time

from experiments.sweep.own_process import peak_memory_mib


def square(number):
    return {"square": number * number}


def threads(_):
    return {"threads": os.environ.get("OMP_NUM_THREADS")}


def yields_threads(_):
    yield threads(_)


def noted(case):
    """Square a number and leave a mark that it was computed."""
    number, folder = case
    with open(f"{folder}/{number}", "a", encoding="utf-8") as file:  # noqa: PTH123
        file.write("x")
    return {"square": number * number}


def fails_at_three(number):
    if number == 3:
        raise ValueError("three")
    return {"square": number}


def dies(_):
    time.sleep(0.2)
    os._exit(9)


def dies_half_way(number):
    yield number
    os._exit(9)


def remembers(size):
    """Tell the peak of memory before and after so many bytes were there."""
    yield peak_memory_mib()
    yield len(b"x" * size) and peak_memory_mib()
