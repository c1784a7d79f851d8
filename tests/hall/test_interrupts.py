"""An interrupt at any moment of an update arrives as what it is, and leaves filter, belief and process as they were."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LIMIT = 300  # [s] for a program that must not hang

# Interrupts updates at random moments, first with nothing beside them, then with the same updates in another thread; each time
# the next update must give the same bits. A second of updates that an interrupt never reaches would be a hang.
INTERRUPTED = """
import faulthandler, signal, sys, threading, time
import numpy as np
from filter import AngularIntervals, Bearing, Compass, Polygon, Range, RobustFilter, SetMembershipFilter, Team, Window

kind, count = sys.argv[1], int(sys.argv[2])
rng, n = np.random.default_rng(0), 5
places, headings = rng.uniform(-4, 4, (n, 2)), rng.uniform(-3, 3, n)
marks = np.array([[0.0, 0.0], [3.0, -3.0]])
team = Team(n, marks, 0.5, 1.0, [[-9, -9], [9, 9]])
estimator = {
    "whole team": lambda: SetMembershipFilter(team),
    "windows": lambda: SetMembershipFilter.light(team, scope=Window(1), threads=2),
    "robust": lambda: RobustFilter(team),
    "searched": lambda: SetMembershipFilter(team, exact=False),
}[kind]()
boxes = [Polygon.box(place - 0.4, place + 0.4) for place in places]
belief = estimator.start(0.0, boxes, AngularIntervals(headings, np.full(n, 0.1)))
who, whom = np.array([(a, b) for a in range(n) for b in range(n + len(marks)) if a != b]).T
apart = np.concatenate([places, marks])[whom] - places[who]
records = [
    Compass(0.0, np.arange(n), headings, 0.05),
    Bearing(0.0, who, whom, np.arctan2(apart[:, 1], apart[:, 0]) - headings[who], 0.05),
    Range(0.0, who, whom, np.hypot(*apart.T), 0.05, 0.0),
]

class Interrupt(BaseException): pass
def handler(*_): raise Interrupt
def bits():
    known = estimator.update(belief, records)
    regions = b"".join(region.outer.vertices.tobytes() for region in known.regions)
    return regions + known.headings.centre.tobytes() + known.headings.bound.tobytes()

bits()
begin = time.perf_counter()
want = bits()
lasts = time.perf_counter() - begin
signal.signal(signal.SIGALRM, handler)

def interrupt(times):
    interrupted = 0
    while interrupted < times:
        try:
            signal.setitimer(signal.ITIMER_REAL, lasts * rng.uniform(0.02, 1.0))
            try:
                estimator.update(belief, records)
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0)
        except Interrupt:
            interrupted += 1
        if interrupted % 10 == 0:
            assert bits() == want, "the next update is another"

def beside():
    while not over:
        alike.append(bits() == want)

over, alike = [], []
interrupt(count)
other = threading.Thread(target=beside)
other.start()
lasts *= 2
interrupt(count // 4)
over.append(True)
other.join()  # a thread that runs on while the interpreter ends is ended in the midst of compiled code
assert alike and all(alike), "an update in a thread beside is another"
print("alive")
"""


@pytest.mark.parametrize("kind", ["whole team", "windows", "robust", "searched"])
def test_an_interrupt_at_any_moment_breaks_nothing(kind):
    command = [sys.executable, "-X", "faulthandler", "-c", INTERRUPTED, kind, "60"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT, check=False)
    assert (run.returncode, run.stdout) == (0, "alive\n"), run.stderr
