"""Linear programs known to be hard, through the LP layer: no bound below the optimum, no false proof of emptiness.

Each is a maximum of c.x over A x <= b, 0 <= x <= upper, with the optimum that the literature gives.
"""

from fractions import Fraction

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog

from filter.linear.program import LinearProgram
from filter.linear.solvers import deepest_point, workspace

# A bound from a solver's multipliers is this close to the optimum, relative to the box.
CLOSE = 1e-5


def klee_minty(count):
    """Return sum of 2^(d-j) x_j, with 2 sum of 2^(i-j) x_j + x_i <= 5^i: the optimum is 5^d (Klee and Minty, 1972)."""
    A = np.array([[2.0 ** (i - j + 1) if j < i else float(i == j) for j in range(count)] for i in range(count)])
    b = 5.0 ** np.arange(1, count + 1)
    return 2.0 ** np.arange(count - 1, -1, -1), A, b, b, 5.0**count


def hilbert(count):
    """Return x >= 0, H x <= H 1, most of 1'H x: x = 1 and y = 1 prove the optimum 1'H1, and next to nothing tells others."""
    A = 1.0 / (1 + np.arange(count)[:, None] + np.arange(count))
    sums = [sum(map(Fraction, row)) for row in A.tolist()]
    rounded = np.array([float(one) for one in sums])
    return rounded, A, rounded, np.full(count, 10.0), float(sum(sums))


def cycling(c, A, b, optimum, upper=100.0):
    return np.array(c), np.array(A), np.array(b), np.full(len(c), upper), optimum


AFIRO = """
X01 X48 .301 R09 -1 R10 -1.06 X05 1; X02 X21 -1 R09 1 COST -.4; X03 X46 -1 R09 1; X04 X50 1 R10 1;
X06 X49 .301 R12 -1 R13 -1.06 X17 1; X07 X49 .313 R12 -1 R13 -1.06 X18 1; X08 X49 .313 R12 -1 R13 -.96 X19 1;
X09 X49 .326 R12 -1 R13 -.86 X20 1; X10 X45 2.364 X17 -1; X11 X45 2.386 X18 -1; X12 X45 2.408 X19 -1; X13 X45 2.429 X20 -1;
X14 X21 1.4 R12 1 COST -.32; X15 X47 -1 R12 1; X16 X51 1 R13 1; X22 X46 .109 R19 -1 R20 -.43 X27 1; X23 X44 -1 R19 1 COST -.6;
X24 X48 -1 R19 1; X25 X45 -1 R19 1; X26 X50 1 R20 1; X28 X47 .109 R22 -.43 R23 -1 X40 1; X29 X47 .108 R22 -.43 R23 -1 X41 1;
X30 X47 .108 R22 -.39 R23 -1 X42 1; X31 X47 .107 R22 -.37 R23 -1 X43 1; X32 X45 2.191 X40 -1; X33 X45 2.219 X41 -1;
X34 X45 2.249 X42 -1; X35 X45 2.279 X43 -1; X36 X44 1.4 R23 1 COST -.48; X37 X49 -1 R23 1; X38 X51 1 R22 1; X39 R23 1 COST 10
"""
AFIRO_RIGHT = {"X50": 310.0, "X51": 300.0, "X05": 80.0, "X17": 80.0, "X27": 500.0, "R23": 44.0, "X40": 500.0}


def afiro():
    """Return netlib's smallest, 27 rows (8 of them equations, as two rows each), with a box around its optimum."""
    columns = [column.split() for column in AFIRO.replace("\n", " ").split(";")]
    rows = sorted({row for column in columns for row in column[1::2]} - {"COST"})
    A, c = np.zeros((len(rows), len(columns))), np.zeros(len(columns))
    for k, column in enumerate(columns):
        for row, value in zip(column[1::2], map(float, column[2::2]), strict=True):
            if row == "COST":
                c[k] = value
            else:
                A[rows.index(row), k] = value
    b = np.array([AFIRO_RIGHT.get(row, 0.0) for row in rows])
    equal = [row.startswith("R") for row in rows]
    return -c, np.concatenate([A, -A[equal]]), np.concatenate([b, -b[equal]]), np.full(len(columns), 1000.0), 464.75314285714285


HARD = {
    "Klee and Minty, 3": lambda: klee_minty(3),
    "Klee and Minty, 6": lambda: klee_minty(6),
    "Klee and Minty, 9": lambda: klee_minty(9),
    "Hilbert, 5": lambda: hilbert(5),
    "Hilbert, 12": lambda: hilbert(12),
    "Beale": lambda: cycling(
        [0.75, -20, 0.5, -6], [[0.25, -8, -1, 9], [0.5, -12, -0.5, 3], [0, 0, 1, 0]], [0, 0, 1], Fraction(5, 4)
    ),
    "Kuhn": lambda: cycling([2, 3, -1, -12], [[-2, -9, 1, 9], [1 / 3, 1, -1 / 3, -2], [2, 3, -1, -12]], [0, 0, 2], Fraction(2)),
    "Marshall and Suurballe": lambda: cycling(
        [0.4, 0.4, -1.8], [[0.6, -6.4, 4.8], [0.2, -1.8, 0.6], [0.4, -1.6, 0.2], [0, 1, 0]], [0, 0, 0, 1], Fraction(2)
    ),
    "Chvatal": lambda: cycling(
        [10, -57, -9, -24], [[0.5, -5.5, -2.5, 9], [0.5, -1.5, -0.5, 1], [1, 0, 0, 0]], [0, 0, 1], Fraction(1)
    ),
    "AFIRO": afiro,
}


def program_of(name):
    c, A, b, upper, optimum = HARD[name]()
    return c, LinearProgram(sparse.csr_array(A), b, np.zeros(len(c)), upper), Fraction(optimum)


def rounding(program):
    """Return what the rounding of the program's own numbers can be worth, against the literature's."""
    return Fraction(1e-14 * float(np.abs(program.upper).max()))


@pytest.mark.parametrize("name", HARD)
def test_the_literature_gives_the_optimum(name):
    c, program, optimum = program_of(name)
    found = linprog(-c, program.A.toarray(), program.b, bounds=np.stack([program.lower, program.upper], axis=1), method="highs")
    assert -found.fun == pytest.approx(float(optimum), rel=1e-7)


@pytest.mark.parametrize("solver", ["piqp", "highs"])
@pytest.mark.parametrize("name", HARD)
def test_no_bound_is_below_the_optimum(name, solver):
    c, program, optimum = program_of(name)
    found = workspace(program, solver).maximize(c)
    rng = np.random.default_rng(0)
    noisy = found.multipliers * rng.uniform(0.5, 1.5, (20, len(program.b)))
    everything = np.concatenate([found.multipliers[None], noisy, rng.exponential(1, noisy.shape)])
    bounds = program.certified_bounds(np.broadcast_to(c, (len(everything), len(c))), everything)
    assert min(map(Fraction, bounds.tolist())) >= optimum - rounding(program)
    extent = float(np.abs(c) @ program.radius)
    assert bounds[0] <= float(optimum) + CLOSE * extent


@pytest.mark.parametrize("solver", ["piqp", "highs"])
@pytest.mark.parametrize("name", HARD)
def test_none_is_proved_empty_until_it_is(name, solver):
    c, program, optimum = program_of(name)
    deepest = deepest_point(program, solver)
    assert deepest is None or not program.proves_empty(deepest.multipliers)
    found = workspace(program, solver).maximize(c)
    assert not program.proves_empty(found.multipliers)
    A = sparse.csr_array(np.vstack([program.A.toarray(), -c]))
    extent = float(np.abs(c) @ program.radius)
    beyond = LinearProgram(A, np.append(program.b, -float(optimum) - 1e-3 * extent), program.lower, program.upper)
    # The bound's own multipliers and one for the row that asks for more than the optimum are a Farkas certificate.
    assert beyond.proves_empty(np.append(found.multipliers, 1.0))
