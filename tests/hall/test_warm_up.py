"""After a warm-up nothing is compiled or loaded any more, whatever is followed; before it, an import loads no solver."""

import subprocess
import sys
from pathlib import Path

from experiments.warm_up import main

ROOT = Path(__file__).parents[2]

# Follows scenes that are unlike that of the warm-up, and names the compiled functions that get another form on the way.
AFTERWARDS = """
import sys
sys.path.insert(0, "tests")
import numpy as np
from filter import FixedLag, Inconsistent, Range, RobustFilter, SetMembershipFilter, Window, follow, frames_of, warm_up
from filter.compiled import MADE
from helpers.drawn.streams import RandomStream
from helpers.worlds import World

warm_up()
assert warm_up() == 0, "a second time"
before = {each: set(each.signatures) for each in MADE}

def look(belief, world):
    for region in belief.regions:
        region.outer.area, region.outer.centroid, region.inner and region.inner.area, region.outer.contains(world.positions)
    belief.headings.contains(world.headings)

SCENES = [(1, 0, True), (2, 1, False), (7, 0, False), (12, 3, True)]
for seed, (robots, landmarks, compasses) in enumerate(SCENES):
    for make in (
        SetMembershipFilter,
        lambda team: SetMembershipFilter.light(team, scope=Window(2)),
        lambda team: SetMembershipFilter(team, policy="reject", pairs=3),
        lambda team: SetMembershipFilter(team, exact=False, solvers=("highs-simplex",)),
        RobustFilter,
    ):
        errors = "extreme" if seed % 2 else "uniform"
        world = World(np.random.default_rng(seed), robots=robots, landmarks=landmarks, errors=errors)
        filter_ = make(world.team)
        if robots > 7 and getattr(filter_, "policy", "raise") == "reject":
            continue  # to look for what is wrong among so many takes long
        belief = filter_.start(0.0, world.initial_sets(), world.initial_headings() if seed % 2 else None)
        for step in range(3):
            motion = world.move(backwards=bool(step % 2))
            records = world.measure(compasses)
            if step == 2 and robots > 1:
                records = [*records, Range(world.time, 0, 1, 30.0, 0.1, 0.0)]  # is a lie
            try:
                belief = filter_.update(filter_.predict(belief, motion.time, motion if step != 1 else None), records)
            except Inconsistent:
                belief = filter_.update(filter_.predict(belief, motion.time))
            look(belief, world)
for seed in range(2):  # streams with positions, mounted sensors and clocks, at once and in time
    stream = RandomStream(np.random.default_rng(seed))
    for filter_ in (SetMembershipFilter(stream.team), SetMembershipFilter.light(stream.team)):
        belief, every = filter_.start(0.0, stream.start, stream.headings), 0.3 * (seed % 2)
        list(follow(filter_, belief, frames_of(stream.team, 0.0, stream.arrivals(), hold=stream.hold), every=every))
        lag = FixedLag(filter_, lag=5.0, every=every)
        lag.merge(lag.begin(belief), sorted(stream.arrivals(), key=lambda each: each.time))
print(sorted(f"{each.py_func.__module__}.{each.__name__}" for each in MADE if set(each.signatures) != before[each]))
"""

# A team whose compiled functions are all on disk, as this has run before.
LOADS = """
import sys
sys.path.insert(0, "tests")
import numpy as np
from filter import SetMembershipFilter
from helpers.worlds import World

world = World(np.random.default_rng(0), robots=3, landmarks=2)
filter_ = SetMembershipFilter(world.team)
belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
motion = world.move()
belief = filter_.update(filter_.predict(belief, motion.time, motion), world.measure(True))
print([region.outer.area > 0 for region in belief.regions])
print(sorted({"scipy.linalg", "numba.np.arraymath"} & sys.modules.keys()))
"""

LIGHT = """
import sys
import filter as f
SOLVERS = {"piqp", "qpsolvers", "highspy", "scipy.stats", "scipy.optimize", "scipy.sparse", "mujoco", "rerun", "rich"}
f.RobustFilter(f.Team(1))
f.SetMembershipFilter(f.Team(1))
print(sorted(SOLVERS & sys.modules.keys()))
f.SetMembershipFilter(f.Team(1), exact=False, solvers=("piqp", "highs-simplex", "highs"))
print(sorted(SOLVERS & sys.modules.keys()))
"""


def said(program):
    run = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=900, check=False)
    assert run.returncode == 0, run.stderr
    return run.stdout.splitlines()


def test_after_a_warm_up_nothing_is_compiled_or_loaded_whatever_is_followed():
    assert said(AFTERWARDS) == ["[]"]


def test_a_filter_loads_no_solver_before_it_is_needed():
    assert said(LIGHT) == ["[]", "[]"]


def test_what_is_on_disk_is_loaded_without_what_only_the_compiler_needs():
    assert said(LOADS)[0] == str([True] * 3)
    assert said(LOADS)[1] == "[]"


def test_the_command_says_how_long_it_took(capsys):
    assert main([]) == 0
    capsys.readouterr()
    assert main([]) == 0
    assert "0 functions compiled" in capsys.readouterr().err
