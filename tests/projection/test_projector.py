"""Which way a projection is found, what is asked when it fails, and what is told."""

import numpy as np
import pytest
from projection.test_exact import EVERYTHING, random_program
from scipy import sparse

from filter.linear.program import LinearProgram
from filter.linear.solvers import workspace
from filter.projection import projector
from filter.projection.fallback import EXACT, Failure, broken_row, project_all
from filter.projection.proved import NOTHING, position
from filter.projection.stop import Stop


class Silent:
    """Makes workspaces that give up."""

    def __call__(self, program):
        return self

    def maximize(self, objective):
        return None


def found(program, solvers, known=NOTHING, stop=EVERYTHING):
    return project_all(program, [position(0, len(program.lower) // 2)], [known], solvers, stop)


def honest(program):
    return workspace(program, "piqp")


PROGRAM = random_program(np.random.default_rng(3), 3, 40)


def test_every_way_gives_the_same_region():
    areas = [found(PROGRAM, solvers).found[0].outer.area for solvers in ([EXACT], ["piqp"], ["highs"], [honest])]
    assert areas == pytest.approx([areas[0]] * 4, rel=1e-5)


def test_the_next_is_asked_and_it_is_told():
    silent = Silent()
    told = found(PROGRAM, [silent, honest])
    assert told.failures == (Failure(None, ("Silent",), "honest"), Failure(0, ("Silent",), "honest"))
    assert told.found[0].reason == "exact"


def test_a_walk_that_goes_wrong_is_replaced_and_it_is_told(monkeypatch):
    monkeypatch.setattr(projector, "project_exactly", lambda *_: None)
    assert found(PROGRAM, [EXACT, "piqp"]).failures == (Failure(0, (EXACT,), "piqp"),)
    alone = found(PROGRAM, [EXACT])
    assert alone.failures == (Failure(0, (EXACT,), None),)
    assert alone.found[0].reason == "solver"


def test_what_was_known_is_left_when_nobody_answers():
    known = np.array([[1.0, 0.0]]), np.array([PROGRAM.lower[0] + 0.05])
    told = found(PROGRAM, [Silent()], known)
    assert told.failures[-1] == Failure(0, ("Silent",), None)
    assert told.found[0].outer.bounds[1][0] == pytest.approx(known[1][0])


def test_a_team_too_large_for_a_walk_is_searched(monkeypatch):
    monkeypatch.setattr(projector, "LARGEST", 5)
    monkeypatch.setattr(projector, "Walker", lambda *_: pytest.fail("it was walked"))
    assert found(PROGRAM, [EXACT, "piqp"], stop=Stop(0.9)).found[0].reason == "performance ratio"


def test_a_row_that_the_box_breaks_is_a_proof():
    box = -np.ones(2), np.ones(2)
    assert broken_row(LinearProgram(sparse.csr_array([[1.0, 1.0]]), np.array([-1.9]), *box)) is None
    assert broken_row(LinearProgram(sparse.csr_array((0, 2)), np.zeros(0), *box)) is None
    program = LinearProgram(sparse.csr_array([[1.0, 1.0], [1.0, 0.0]]), np.array([-2.1, 0.0]), *box)
    assert broken_row(program).tolist() == [1.0, 0.0]
    assert found(program, [EXACT]).found == ()
