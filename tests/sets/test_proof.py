"""Where an edge comes from: through all rounds of an update, back to what was there before it."""

import numpy as np

from filter import Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.projection.claims import Weights
from filter.sets.proof import Proof, causes_of
from filter.team import Team

EAST, NORTH = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def rested(of, claimed, rows, origin=()):
    """Return a proof of one claim on robot 0, a normal, from rows on it: a normal, a kind of source and its time each."""
    table, numbers = Sources(), []
    for _, kind, time in (*rows, *((None, *each) for each in origin)):
        table, number = table.extended(kind, time, np.array([0]))
        numbers.append(int(number[0]))
    count = len(rows)
    normals = np.array([normal for normal, *_ in rows]).reshape(-1, 2)
    whose = np.full(count, WORLD), np.zeros(count, dtype=np.int64)
    constraints = Constraints(*whose, normals, np.ones(count), np.array(numbers[:count], dtype=np.int64))
    polytope = Polytope(constraints, -np.ones((1, 2)), np.ones((1, 2)), np.array(numbers[count:], dtype=np.int64))
    weights = Weights(np.arange(count), np.ones(count), np.array([0, count]))
    return Proof(of, polytope, table, np.array([WORLD]), np.array([0]), claimed[None], np.ones(1), weights)


def kinds(proofs, normal, time=1.0):
    return {(source.kind, source.time) for source in causes_of(proofs, time, (WORLD, 0, normal), set())}


def test_what_an_edge_rests_on_is_named():
    assert kinds([rested("regions", EAST, [(NORTH, "range", 1.0), (EAST, "region", 0.5)])], EAST) == {
        ("range", 1.0),
        ("region", 0.5),
    }


def test_an_edge_of_the_round_before_stands_for_what_it_was_proved_from():
    first = rested("regions", NORTH, [(EAST, "cells", 1.0), (EAST, "initial set", 0.0)])
    second = rested("regions", EAST, [(NORTH, "region", 1.0), (EAST, "bearing", 1.0)])
    assert kinds([first, second], EAST) == {("cells", 1.0), ("initial set", 0.0), ("bearing", 1.0)}
    assert kinds([second], EAST) == {("region", 1.0), ("bearing", 1.0)}  # of that nothing is known


def test_a_side_of_the_box_is_what_the_box_comes_from():
    first = rested("boxes", EAST, [(NORTH, "range", 1.0)])
    second = rested("regions", EAST, [], origin=[("region", 1.0)])
    assert kinds([first, second], EAST) == {("range", 1.0)}
    assert kinds([rested("regions", EAST, [], origin=[("initial set", 0.0)])], EAST) == {("initial set", 0.0)}


def test_of_an_edge_without_a_proof_the_answer_is_what_was_said_otherwise():
    said = {Sources().extended("arena", 0.0, np.array([0]))[0][0]}
    assert causes_of([rested("regions", EAST, [(EAST, "range", 1.0)])], 1.0, (WORLD, 0, NORTH), said) == said


def test_edges_of_a_later_round_name_what_they_were_proved_from_before_the_update():
    """Of what the first round found, `region` at the same time would say nothing."""
    places = np.array([[0.0, 0.0], [2.0, 0.5], [-1.0, 2.0]])
    marks = np.array([[-4.0, -3.0], [4.0, -3.0], [0.0, 5.0]])
    bodies = np.concatenate([places, marks])
    who, whom = np.array([(a, b) for a in range(3) for b in range(a + 1, 6)]).T
    away = np.hypot(*(bodies[whom] - bodies[who]).T)
    estimator = SetMembershipFilter(Team(3, marks, 0.5, 1.0))
    start = estimator.start(0.0, [Polygon.box([-6, -6], [6, 6])] * 3)
    found = estimator.update(start, [Range(0.0, who, whom, away, 0.1, 0.0)])
    assert len(list(found.proofs_of("regions"))) > 1
    for robot, region in enumerate(found.regions):
        for edge in range(len(region.causes)):
            named = found.causes(robot, edge)
            assert {source.kind for source in named} <= {"range", "cells", "initial set"}, named
            assert named
