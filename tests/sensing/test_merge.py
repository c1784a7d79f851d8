"""What measurements add: rows that hold for the truth, bearings before ranges, each with its source."""

import numpy as np
import pytest
from helpers.programs import merging
from helpers.teams import begun
from helpers.worlds import World, exact_row_slack

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.guarantee import Guarantee
from filter.linear.sources import Source
from filter.sensing.readings import KIND_OF, Readings
from filter.sets.belief import Belief

SPACING = np.radians(15)


def start(world):
    return begun(SetMembershipFilter(world.team), world)


def taken(belief, world, records, spacing=SPACING):
    """Return a belief with the rows of records."""
    sources, _ = Readings.of(belief.time, records).numbered(belief.sources, world.team.robots)
    found = merging(belief, records, world.team, spacing, cells=0).merged()
    return Belief(0.0, found.polytope, found.headings, sources, Guarantee.full(len(found.headings)))


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("origin", [0.0, 5e6])
def test_every_row_holds_for_the_truth_and_names_its_measurement(errors, origin):
    world = World(np.random.default_rng(1), errors=errors, origin=np.full(2, origin))
    records = world.measure()
    before = start(world)
    after = taken(before, world, records)
    assert all(exact_row_slack(row, after, world.positions) >= 0 for row in range(len(after.constraints)))
    named = {str(after.sources[k]) for k in after.constraints.source.tolist()}
    for record in records[1:]:
        for robot, target in zip(record.robot.tolist(), record.target.tolist(), strict=True):
            assert str(Source(KIND_OF[type(record)], 0.0, robot, target)) in named
    assert set(before.constraints.offset.tolist()) <= set(after.constraints.offset.tolist())
    assert (after.polytope.lower == before.polytope.lower).all()


def test_bearings_narrow_the_directions_of_ranges_in_any_order():
    world = World(np.random.default_rng(2))
    compasses, bearings, ranges = world.measure()
    before = start(world)
    both, turned, alone = (
        taken(before, world, records)
        for records in ([compasses, bearings, ranges], [ranges, compasses, bearings], [compasses, ranges])
    )
    columns = [np.sort(each.constraints.offset).tolist() for each in (both, turned)]
    assert columns[0] == pytest.approx(columns[1], abs=1e-12)
    i, j = np.triu_indices(4, 1)
    measured = np.array([len(both.constraints.rows_of(first, second)) > 0 for first, second in zip(i, j, strict=True)])
    of_ranges = [of_kind(each, "range").of(i[measured], j[measured]).polygons.areas for each in (both, alone)]
    assert (of_ranges[0] < of_ranges[1]).all()


def of_kind(belief, kind):
    """Return a belief's polytope with the rows alone that one kind of measurement made."""
    made = np.array([belief.sources[number].kind == kind for number in belief.constraints.source.tolist()])
    return belief.polytope.with_constraints(belief.constraints.select(made))


def test_a_finer_spacing_makes_more_rows():
    world = World(np.random.default_rng(2), robots=2)
    _, _, ranges = world.measure()
    before = start(world)
    fine, coarse = (taken(before, world, [ranges], spacing) for spacing in (0.05, 1.0))
    assert len(fine.constraints) > len(coarse.constraints)


def test_without_records_nothing_changes():
    world = World(np.random.default_rng(0))
    before = start(world)
    after = taken(before, world, [])
    assert after.constraints.offset.tolist() == before.constraints.offset.tolist()
    assert after.headings.bound.tolist() == before.headings.bound.tolist()
