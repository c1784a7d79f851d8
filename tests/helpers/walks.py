"""Walks over the vertices of small programs, as far as the tests of more than one of their parts need them."""

import numpy as np
from helpers.programs import random_polytope, team_program

from filter.projection.simplex import corner

LIMIT = 2000


def dense(rows, variables):
    """Return the rows as a matrix."""
    matrix = np.zeros((len(rows.offset), variables))
    for i in range(len(rows.offset)):
        np.add.at(matrix[i], rows.column[i], rows.value[i])
    return matrix


def begun(seed, robots=4, count=60):
    """Return the rows of a random team, the basis of a corner of its box, and the objective that is greatest there."""
    rows = team_program(random_polytope(np.random.default_rng(seed), robots, count)).rows
    objective = np.random.default_rng(seed + 100).uniform(0.5, 1, 2 * robots) * (-1.0) ** np.arange(2 * robots)
    return rows, corner(rows, objective), objective
