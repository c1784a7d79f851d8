"""What a filter is given of one instant."""

import numpy as np
import pytest

from filter import AngularIntervals, Compass, Frame, InvalidInput, Left, Placed, Polygon, Truth

BOX = Polygon.box([0, 0], [1, 1])


def test_it_keeps_what_it_is_given_as_tuples():
    said = [Compass(1.0, 0, 0.1, 0.1)]
    changes = [Left(1.0, 1), Placed(1, np.int64(1), BOX, AngularIntervals([0.1], [0.2]))]
    frame = Frame(1, None, said, changes=changes)
    said.clear()
    changes.reverse()
    assert (frame.time, len(frame.measurements), [type(each) for each in frame.changes]) == (1.0, 1, [Left, Placed])
    assert (frame.changes[1].time, frame.changes[1].robot) == (1.0, 1)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Frame(1.0, changes=["bob"]), "robots that are placed or have left"),
        (lambda: Frame(1.0, changes=Left(1.0, 0)), "robots that are placed or have left"),
        (lambda: Frame(1.0, measurements=[Left(1.0, 0)]), "records of compass"),
        (lambda: Left(1.0, -1), "robot"),
        (lambda: Left(1.0, 0.5), "robot"),
        (lambda: Placed(np.nan, 0), "time"),
        (lambda: Placed(1.0, 0, [[0, 0], [1, 1]]), "polygon"),
        (lambda: Placed(1.0, 0, BOX, 0.5), "arc"),
        (lambda: Truth([[0, 0]], [0, 1]), r"positions \(n, 2\) and headings"),
    ],
)
def test_what_is_none_is_refused(make, said):
    with pytest.raises(InvalidInput, match=said):
        make()
