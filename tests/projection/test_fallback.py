"""What solvers find where nobody walks, which is asked when one fails, and what is told."""

import numpy as np
import pytest
from helpers.programs import EVERYTHING, random_polytope, support
from helpers.worlds import unit
from scipy import sparse

from filter.linear.program import Candidate, LinearProgram
from filter.linear.solvers import workspace
from filter.projection.fallback import Fallback, broken_row, interior, project_all
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


PROGRAM = random_polytope(np.random.default_rng(3), 3, 40).program()


def test_every_solver_gives_the_same_region():
    areas = [found(PROGRAM, solvers).complete[0].outer.area for solvers in (["piqp"], ["highs"], [honest])]
    assert areas == pytest.approx([areas[0]] * 3, rel=1e-5)


def test_each_projection_has_its_place():
    planes = [position(robot, 3) for robot in (2, 0, 1)]
    told = project_all(PROGRAM, planes, [NOTHING] * 3, ["piqp"], EVERYTHING)
    assert len(told.complete) == 3
    for D, each in zip(planes, told.complete, strict=True):
        for direction in unit(np.linspace(-np.pi, np.pi, 13)):
            assert each.outer.support(direction[None])[0] == pytest.approx(support(PROGRAM, direction @ D), abs=1e-6)


def test_the_next_is_asked_and_it_is_told():
    silent = Silent()
    told = found(PROGRAM, [silent, honest])
    assert told.failures == (Fallback(None, ("Silent",), "honest"), Fallback(0, ("Silent",), "honest"))
    assert told.complete[0].reason == "exact"


def test_an_answer_whose_proof_is_loose_is_no_good():
    def proofless(program):
        true = honest(program)

        class Workspace:
            def maximize(self, objective):
                return Candidate(true.maximize(objective).point, np.zeros(len(program.b)))

        return Workspace()

    told = found(PROGRAM, [proofless, "piqp"])
    assert told.failures[-1] == Fallback(0, ("proofless",), "piqp")
    alone = found(PROGRAM, [proofless])
    assert alone.failures[-1] == Fallback(0, ("proofless",), None)
    assert alone.complete[0].outer.area > told.complete[0].outer.area


def test_what_was_known_is_left_when_nobody_answers():
    known = np.array([[1.0, 0.0]]), np.array([PROGRAM.lower[0] + 0.05])
    for solvers in ([Silent()], []):
        told = found(PROGRAM, solvers, known)
        assert told.complete[0].reason == "solver"
        assert told.complete[0].outer.bounds[1][0] == pytest.approx(known[1][0])
        assert told.complete[0].inner is None
    assert found(PROGRAM, [Silent()], known).failures[-1] == Fallback(0, ("Silent",), None)


def test_time_that_runs_out_leaves_projections_out():
    looks = iter([False, *[True] * 99])
    told = project_all(PROGRAM, [position(0, 3), position(1, 3)], [NOTHING] * 2, ["piqp"], Stop(), is_over=lambda: next(looks))
    assert told.complete[0].reason == "time"
    assert told.complete[0].searches == 4
    assert len(told.complete) == 1


def test_a_row_that_the_box_breaks_is_a_proof():
    box = -np.ones(2), np.ones(2)
    assert broken_row(LinearProgram(sparse.csr_array([[1.0, 1.0]]), np.array([-1.9]), *box)) is None
    assert broken_row(LinearProgram(sparse.csr_array((0, 2)), np.zeros(0), *box)) is None
    program = LinearProgram(sparse.csr_array([[1.0, 1.0], [1.0, 0.0]]), np.array([-2.1, 0.0]), *box)
    assert broken_row(program).tolist() == [1.0, 0.0]
    told = found(program, [])
    assert told.complete == ()
    assert program.proves_empty(told.contradiction)


def test_the_interior_is_proved_or_there_is_none():
    inside = interior(PROGRAM, [Silent(), "piqp"])
    assert PROGRAM.holds(inside.point[None])[0]
    assert inside.failures == (Fallback(None, ("Silent",), "piqp"),)
    nobody = interior(PROGRAM, [])
    assert nobody.point.tolist() == PROGRAM.centre.tolist()
    rows = sparse.csr_array([[1.0, 0.0], [-1.0, 0.0]])
    empty = LinearProgram(rows, np.array([0.4, -0.6]), np.zeros(2), np.ones(2))
    assert empty.proves_empty(interior(empty, [Silent(), "piqp"]).contradiction)
    line = LinearProgram(sparse.csr_array([[0.6, -0.8], [-0.6, 0.8]]), np.array([0.1, -0.1]), np.zeros(2), np.ones(2))
    doubtful = interior(line, ["highs"])
    assert doubtful.contradiction is None
    assert doubtful.failures == (Fallback(None, ("highs",), None),)


def test_a_row_of_more_than_four_entries_is_no_trouble():
    program = LinearProgram(sparse.csr_array(np.ones((1, 6))), np.zeros(1), -np.ones(6), np.ones(6))
    assert found(program, ["piqp"]).complete[0].outer.area == pytest.approx(4.0)
