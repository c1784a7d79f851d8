"""What a belief holds: sources in words, and nothing that is not needed."""

import dataclasses

import numpy as np
import pytest
from helpers.worlds import World, exact_claim

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.linear.sources import KINDS, Source, Sources
from filter.sets.proof import Proof


def arrays_within(thing):
    """Yield every array in a record, a tuple or a list, with a name."""
    if isinstance(thing, np.ndarray):
        yield thing
    elif isinstance(thing, tuple | list):
        for part in thing:
            yield from arrays_within(part)
    elif dataclasses.is_dataclass(thing):
        for column in dataclasses.fields(thing):
            yield from arrays_within(getattr(thing, column.name))


@pytest.fixture(scope="module")
def believed():
    """Return a belief before, in and after an update."""
    world = World(np.random.default_rng(0), robots=3)
    filter_ = SetMembershipFilter(world.team)
    start = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    updated = filter_.update(start, world.measure())
    return start, updated, filter_.predict(updated, 0.1, world.move())


def test_every_array_of_a_belief_is_read_only(believed):
    for belief in believed:
        found = list(arrays_within((belief, belief.regions)))
        assert len(found) > 20
        assert not any(array.flags.writeable for array in found if array.size)


def test_a_belief_cannot_be_changed(believed):
    with pytest.raises(dataclasses.FrozenInstanceError):
        believed[0].time = 1.0


def test_the_table_holds_only_what_rows_and_edges_name(believed):
    for belief in believed:
        named = [belief.constraints.source, belief.polytope.origin] + [
            cause for region in belief.regions for cause in region.causes
        ]
        assert np.unique(np.concatenate(named)).tolist() == list(range(len(belief.sources)))


def test_every_edge_has_its_causes(believed):
    for belief in believed:
        for robot, region in enumerate(belief.regions):
            assert len(region.causes) == len(region.outer.offsets)
            for edge in range(len(region.causes)):
                assert all(source.kind in KINDS for source in belief.causes(robot, edge))


def test_causes_after_an_update_name_measurements(believed):
    _, updated, _ = believed
    named = {
        source.kind
        for robot in range(3)
        for edge in range(len(updated.regions[robot].causes))
        for source in updated.causes(robot, edge)
    }
    assert {"bearing", "range"} <= named
    assert all(source.time == 0.0 for robot in range(3) for source in updated.causes(robot, 0))


def test_before_any_measurement_causes_name_the_initial_set(believed):
    start, _, _ = believed
    named = {source for robot in range(3) for edge in range(4) for source in start.causes(robot, edge)}
    assert all(source.kind == "initial set" for source in named)


def test_what_is_known_from_inside_ends_with_a_prediction(believed):
    start, updated, predicted = believed
    assert all(region.inner is not None and region.performance_ratio > 0.5 for region in updated.regions)
    assert all(region.inner is None and region.performance_ratio == 0 for region in (*start.regions, *predicted.regions))


def test_a_table_of_sources_grows_and_is_selected():
    table, first = Sources().extended("compass", 1.0, [0, 1])
    table, second = table.extended("bearing", 2.0, 1, [4])
    assert (first.tolist(), second.tolist()) == ([0, 1], [2])
    assert table[2] == Source("bearing", 2.0, 1, 4)
    assert table[0] == Source("compass", 1.0, 0, None)
    assert table.select(np.array([2]))[0].target == 4


def test_a_source_says_who_what_and_when():
    assert str(Source("range", 1.5, 2, 7)) == "range of robot 2 to 7 at 1.500 s"
    assert str(Source("region", 0.0, 2)) == "region of robot 2 at 0.000 s"


def test_regions_are_those_of_the_update_or_else_what_is_known_at_a_glance(believed):
    start, updated, predicted = believed
    assert updated.regions is updated.found
    for belief in (start, predicted):
        assert belief.found is None
        assert belief.regions is belief.regions
        own = belief.polytope.of_robots(np.arange(3)).polygons
        assert [region.outer.offsets.tolist() for region in belief.regions] == [each.offsets.tolist() for each in own]
        assert all(region.reason is None and region.searches == 0 for region in belief.regions)
        assert belief.proofs == ()
        assert belief.events == ()


def test_a_compact_belief_says_the_same_of_fewer_sources(believed):
    _, updated, _ = believed
    table, _ = updated.sources.extended("compass", 9.0, [0, 1])
    swollen = dataclasses.replace(updated, sources=table).compact()
    assert len(swollen.sources) == len(updated.sources) < len(table)
    for robot in range(3):
        for edge in range(len(updated.regions[robot].causes)):
            assert swollen.causes(robot, edge) == updated.causes(robot, edge)
    rows = updated.constraints.source.tolist()
    assert [swollen.sources[k] for k in swollen.constraints.source.tolist()] == [updated.sources[k] for k in rows]


def test_proofs_are_of_all_edges_of_the_sides_of_the_boxes_and_of_pairs(believed):
    _, updated, _ = believed
    edges, boxes, pairs = ([*updated.proofs_of(what)][-1] for what in ("regions", "boxes", "pairs"))
    assert edges.j.tolist() == updated.regions.outer.owner.tolist()
    assert edges.offset.tolist() == updated.regions.outer.offsets.tolist()
    assert set(zip(pairs.i.tolist(), pairs.j.tolist(), strict=True)) == {(0, 1), (0, 2), (1, 2)}
    assert len(boxes) == 12
    for proof in (proof for proof in updated.proofs if isinstance(proof, Proof)):
        for claim in range(len(proof)):
            rows, multipliers = proof.rests_on(claim)
            assert len(rows) == len(multipliers)
            assert exact_claim(proof, claim) <= 0
