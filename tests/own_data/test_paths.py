"""Paths into messages: what they find, and that a wrong one is told with the nearest right word."""

from types import SimpleNamespace as Message

import pytest

from experiments.recorded.paths import check_path, compiled_path
from filter import InvalidInput

NUMBER, TEXT = (1, ("float64", 0)), (1, ("string", 0))
TYPES = {
    "p/msg/Seen": ([], [("id", TEXT), ("place", (2, "p/msg/Place")), ("covariance", (3, (NUMBER, 4)))]),
    "p/msg/Place": ([], [("bearing", NUMBER), ("range", NUMBER)]),
    "p/msg/All": ([], [("detections", (4, ((2, "p/msg/Seen"), 0))), ("count", NUMBER)]),
}


def seen(name, bearing):
    return Message(id=name, place=Message(bearing=bearing, range=2.0), covariance=[1.0, 2.0, 3.0, 4.0])


MESSAGE = Message(detections=[seen("a", 0.1), seen("b", 0.2)], count=2.0)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("count", 2.0),
        ("detections[*].id", ["a", "b"]),
        ("detections[*].place.bearing", [0.1, 0.2]),
        ("detections[1].place.bearing", 0.2),
        ("detections[*].covariance[3]", [4.0, 4.0]),
    ],
)
def test_a_path_finds_what_it_names(path, value):
    check_path(path, "p/msg/All", TYPES)
    assert compiled_path(path)(MESSAGE) == value


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("detection[*].id", 'did you mean "detections"'),
        ("detections[*].place.baring", 'did you mean "bearing"'),
        ("detections.id", "[*], or the number"),
        ("count[*]", "an array before"),
        ("count.id", "nothing after a float64"),
        ("detections[*].covariance[*]", "one array at most"),
        ("detections[x]", "a path as in"),
        (".count", "a path as in"),
        ("", "a path"),
    ],
)
def test_a_path_that_is_wrong_is_told(path, told):
    with pytest.raises(InvalidInput) as error:
        check_path(path, "p/msg/All", TYPES)
    assert told in str(error.value)
