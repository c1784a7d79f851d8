"""When it is worth it to go on: by how many robots, by how much area, and while that becomes smaller."""

import numpy as np

from filter.sets.worth import are_smaller, matter


def test_robots_matter_by_number_or_by_area():
    few, alike = np.array([7]), np.ones(100)
    lost = np.where(np.arange(100) == 7, 1e6, 1.0)
    assert not matter(np.zeros(0, dtype=int), alike)
    assert not matter(few, alike)  # 1 of 100
    assert matter(np.arange(10), alike)  # 10 of 100
    assert matter(few, lost)  # almost all of the area
    assert not matter(np.arange(7), lost)
    assert matter(few, np.zeros(100))  # no area at all is a share of none
    assert matter(few, np.ones(10))


def test_areas_are_smaller_all_together_or_most_of_them():
    before = np.array([1e6, 1.0, 1.0, 1.0])
    assert not are_smaller(before, before)
    assert are_smaller(before * 0.96, before)
    assert not are_smaller(before * 0.98, before)
    assert are_smaller(np.array([1e6, 0.9, 0.9, 0.9]), before)  # by 7.5 % each in the mean
    assert are_smaller(np.array([9e5, 1.0, 1.0, 1.0]), before)  # by 10 % all together
    assert not are_smaller(np.array([1e6, 1.0, 1.0, 0.9]), before)  # by 2.5 % each in the mean
    assert not are_smaller(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    assert are_smaller(np.array([0.0, 0.9]), np.array([0.0, 1.0]))
