"""Work in threads: all of it, in order; and whoever is interrupted while waiting for it goes on at once."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import get_ident

import pytest

from filter.workers import spread

ROOT = Path(__file__).parents[2]
LIMIT = 60  # [s] for a program that must not hang

INTERRUPTED = """
import signal, sys, time
from filter.workers import spread

class Interrupt(BaseException): pass
def handler(*_): raise Interrupt
signal.signal(signal.SIGALRM, handler)
end, count = time.monotonic() + float(sys.argv[1]), 0
while time.monotonic() < end:
    try:
        signal.setitimer(signal.ITIMER_REAL, 1e-6 * (1 + 37 * count % 1000))
        while True:
            assert spread(abs, range(-4, 0), 2) == [4, 3, 2, 1]
    except Interrupt:
        count += 1
signal.setitimer(signal.ITIMER_REAL, 0)
print(count)
"""

LEFT_AT_WORK = """
import sys, time
from filter.workers import spread

def work(item):
    time.sleep(0.5 / (1 + item))
    sys.stdout.write(f"{item} ended;")
    return 1 / (item - 1)
spread(work, [0, 1, 2, 3], 2)
"""


def program(text, *arguments):
    command = [sys.executable, "-c", text, *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT, check=False)


@pytest.mark.parametrize("threads", [1, 3, 50])
def test_the_results_are_in_the_order_of_the_items(threads):
    assert spread(lambda item: item**2, range(20), threads) == [item**2 for item in range(20)]
    assert spread(str, [], threads) == []


def test_nothing_is_done_by_the_caller_and_everything_by_so_many_threads():
    def work(_):
        time.sleep(0.05)
        return get_ident()

    workers = spread(work, range(8), 2)
    assert len(set(workers)) == 2
    assert get_ident() not in workers


def test_what_the_work_raises_is_raised_and_no_more_is_begun():
    begun = []

    def work(item):
        begun.append(item)
        return 1 / item

    with pytest.raises(ZeroDivisionError):
        spread(work, [1, 0, 2, 3], 1)
    assert begun == [1, 0]


def test_an_interrupt_of_the_caller_arrives_at_once():
    def handler(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        begin = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            spread(time.sleep, [1.0], 1)
        assert time.monotonic() - begin < 0.5
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_no_interrupt_at_any_moment_makes_it_hang():
    """The pools of `concurrent.futures` hang within seconds of this."""
    run = program(INTERRUPTED, "4")
    assert run.returncode == 0, run.stderr
    assert int(run.stdout) > 100


def test_what_is_at_work_ends_before_the_interpreter_does_and_the_rest_is_not_begun():
    run = program(LEFT_AT_WORK)
    assert "ZeroDivisionError" in run.stderr
    assert run.stdout == "1 ended;0 ended;"
