"""The two readers of a log's lines: what the fast one accepts the strict one accepts, and they give the same record."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.logs import records
from experiments.logs.fields import Fields
from experiments.logs.lines import Lines
from experiments.logs.strict import read_record
from filter import Frame, InvalidInput, Odometry, Team

TEAM = Team(3, [[0.5, 1.0], [-2.0, 1.5]], 0.7, 1.5, [[-6, -6], [6, 6]])
FAST = Lines(TEAM)
SPELLINGS = ("{!r}", "{:.3e}", "{:.1f}", "{:.0f}", "{:+.17E}")
LIMITS = [0.0, -0.0, 5e-324, 1.0, np.pi / 2, np.pi, 1e100]
EDGES = sorted({float(near) for edge in LIMITS for near in (edge, np.nextafter(edge, 0), np.nextafter(edge, np.inf))})


@st.composite
def numbers(draw, low=-1e100, high=1e100):
    """Numbers within a field's limits, as people and programs spell them."""
    value = draw(st.one_of(st.sampled_from([each for each in EDGES if low <= each <= high]), st.floats(low, high)))
    texts = [spelling.format(value).replace("+", "", 1) for spelling in SPELLINGS]
    return draw(st.sampled_from([*(text for text in texts if low <= float(text) <= high), "-0", "1e-3"]))


ANY, POSITIVE, BELOW_90 = numbers(), numbers(0, 1e100), numbers(0, 1.5707963267948963)
COLUMNS = {
    "odometry": {
        "distance": ANY,
        "distance_bound": POSITIVE,
        "turn": ANY,
        "turn_bound": POSITIVE,
        "direction_bound": BELOW_90,
        "slip_bound": POSITIVE,
    },
    "compass": {"heading": ANY, "bound": numbers(0, np.pi)},
    "bearing": {"bearing": ANY, "bound": BELOW_90},
    "range": {"range": POSITIVE, "bound": POSITIVE, "relative_bound": numbers(0, 0.9999999999999999)},
}


def listed(tokens):
    return f"[{', '.join(tokens)}]"


def column(values, count):
    """A column of one length, or one number for all of it."""
    return st.one_of(values, st.lists(values, min_size=count, max_size=count).map(listed))


@st.composite
def sighted(draw, count):
    """The columns of robots and of those that they see, another robot or a landmark each."""
    robots = draw(st.lists(st.integers(0, 2), min_size=count, max_size=count))
    mates = [draw(st.sampled_from([None, *({0, 1, 2} - {robot})])) for robot in robots]
    marks = [draw(st.integers(0, 1)) if mate is None else None for mate in mates]
    seen = {"target": mates, "landmark": marks}
    if draw(st.booleans()):
        seen = {name: bodies for name, bodies in seen.items() if any(body is not None for body in bodies)} or {"target": []}
    told = {name: listed("null" if body is None else str(body) for body in bodies) for name, bodies in seen.items()}
    alone = count == 1 and draw(st.booleans())
    return {name: text.strip("[]") if alone else text for name, text in {"robot": str(robots), **told}.items()}


@st.composite
def lines(draw):
    """The fields of a line, as text."""
    kind = draw(st.sampled_from([*COLUMNS, "truth", "frame"]))
    fields = {"record": f'"{kind}"', "time": draw(ANY)}
    if kind == "truth":
        points = [listed([draw(ANY), draw(ANY)]) for _ in range(3)]
        fields |= {"positions": listed(points), "headings": listed([draw(ANY) for _ in range(3)])}
    if kind in COLUMNS:
        count = draw(st.integers(0, 3))
        moved = str(draw(st.permutations(range(3)))[:count])
        fields |= {"robot": moved, "start": "-1e100"} if kind == "odometry" else {"robot": str([0] * count)}
        fields |= draw(sighted(count)) if kind in ("bearing", "range") else {}
        fields |= {name: draw(column(values, count)) for name, values in COLUMNS[kind].items()}
    order = draw(st.permutations(list(fields)))
    return [(name, fields[name]) for name in order]


def text_of(fields, comma=", ", colon=": "):
    return ("{" + comma.join(f'"{name}"{colon}{value}' for name, value in fields) + "}\n").encode()


def strict(text):
    """Return what the strict reader says, None for a refusal."""
    try:
        return read_record(Fields.parse(text), TEAM)
    except InvalidInput:
        return None


def told(record):
    """Return all that a record is, to the last bit."""
    values = record._asdict() if isinstance(record, tuple) else vars(record)
    return type(record), {name: _told(value) for name, value in values.items()}


def _told(value):
    if isinstance(value, np.ndarray):
        return value.dtype, value.shape, value.tobytes(), value.flags.writeable, value.flags.owndata
    return told(value) if hasattr(value, "__dict__") else (type(value), np.float64(value).tobytes())


@settings(max_examples=300)
@given(lines(), st.sampled_from([", ", ",", " ,\t"]), st.sampled_from([": ", ":", " : "]))
def test_the_fast_reader_gives_what_the_strict_one_gives(fields, comma, colon):
    text = text_of(fields, comma, colon)
    slowly, fast = strict(text), FAST.read(text)
    assert slowly is not None
    assert fast is not None
    assert told(fast) == told(slowly)


BASES = [
    {"record": "odometry", "start": 0.5, "time": 1, "robot": 0, **dict.fromkeys(COLUMNS["odometry"], 0.25)},
    {"record": "odometry", "start": 0.5, "time": 1, "robot": [2, 0], **{name: [0.25, 1] for name in COLUMNS["odometry"]}},
    {"record": "compass", "time": 1, "robot": 2, "heading": 0.25, "bound": 0.5},
    {"record": "compass", "time": 1, "robot": [2, 1], "heading": [0.25, 1], "bound": 0.5},
    {"record": "bearing", "time": 1, "robot": 2, "target": 1, "bearing": 0.25, "bound": 0.5},
    {"record": "bearing", "time": 1, "robot": 0, "target": None, "landmark": 1, "bearing": 0.25, "bound": 0.5},
    {
        "record": "bearing",
        "time": 1,
        "robot": [0, 2],
        "target": [None, 1],
        "landmark": [0, None],
        "bearing": 1,
        "bound": [0, 1],
    },
    {"record": "range", "time": 1, "robot": 0, "landmark": 1, "range": 4, "bound": 0.5, "relative_bound": 0},
    {"record": "range", "time": 1, "robot": 0, "target": [1, 2], "range": [4, 0], "bound": 0, "relative_bound": [0.1, 0]},
    {"record": "truth", "time": 1, "positions": [[0, 1], [0.5, -1], [7, 7]], "headings": [0, 1, 2.5]},
    {"record": "frame", "time": 1},
]
NUMBERS = [sign + repr(edge) for edge in EDGES for sign in ("", "-")] + [
    "2",
    "3",
    "1e101",
    "1e999",
    "9" * 400,
    "01",
    "1.",
    ".5",
]
BODIES = [
    [0],
    [3],
    [0, 0],
    [0, 1],
    [1, 0],
    [0, 3],
    [0, -1],
    [1, 0, 2],
    [0, None, None],
    [None, 0],
    [0, None],
    [None, None],
    [1.0, 0],
    [True, 0],
]
LISTS = [[-0.1, 0.1], [0.1, 2], ["1", 0], [[0, 1]], [[0, 1], [0, 1], [0]], [[0, 1]] * 4, [[0, None]] * 3, [0.5] * 4]
OTHERS = ["true", "null", '"1"', '"a:b"', "NaN", "-Infinity", "[]", "{}", '{"a": 1}', '"frame"', '"compass"', '"range"']
JUNK = NUMBERS + OTHERS + [str(each).replace("None", "null").replace("True", "true") for each in BODIES + LISTS]


def changes(fields):
    """Yield the fields with one of them changed, left out, there twice or too many."""
    for place, (name, value) in enumerate(fields):
        before, after = fields[:place], fields[place + 1 :]
        yield from ([*before, (name, junk), *after] for junk in JUNK)
        yield from ([*before, *after], [*fields, (name, value)], [*before, (name.upper(), value), *after])
    yield from ([*fields, (name, junk)] for name in ("target", "landmark", "sigma") for junk in ("0", "null", "[0, 1]"))


@pytest.mark.parametrize("base", BASES, ids=lambda base: base["record"])
def test_what_the_strict_reader_refuses_the_fast_one_refuses(base):
    fields = [(name, json.dumps(value)) for name, value in base.items()]
    assert FAST.read(text_of(fields)) is not None
    refused = 0
    for changed in changes(fields):
        slowly, fast = strict(text_of(changed)), FAST.read(text_of(changed))
        refused += slowly is None
        assert fast is None or (slowly is not None and told(fast) == told(slowly)), changed
    assert refused > len(JUNK) / 2


@pytest.mark.parametrize("robots", [2, 4])
def test_the_truth_of_too_few_or_too_many_is_refused_by_both(robots):
    truth = {"record": "truth", "time": 1, "positions": [[0, 0]] * robots, "headings": [0] * robots}
    assert strict(json.dumps(truth).encode()) is FAST.read(json.dumps(truth).encode()) is None


@settings(max_examples=300)
@given(lines(), st.integers(0, 10_000), st.integers(0, 255))
def test_a_byte_that_flips_makes_no_difference_between_the_readers(fields, place, byte):
    text = bytearray(text_of(fields))
    text[place % len(text)] = byte
    slowly, fast = strict(bytes(text)), FAST.read(bytes(text))
    assert fast is None or (slowly is not None and told(fast) == told(slowly))


@pytest.mark.parametrize("text", [b"[" * 100_000, b'{"record":' * 100_000, b'{"record": "frame", "time": ' + b"[" * 100_000])
def test_endless_nesting_is_refused_by_both(text):
    assert strict(text) is None
    assert FAST.read(text) is None


def test_what_is_settled_is_what_the_public_constructor_makes():
    columns = {name: np.arange(2.0) / 4 for name in (*COLUMNS["odometry"], "aside")}
    for values in columns.values():
        values.setflags(False)
    robots = np.arange(2)
    robots.setflags(False)
    settled = records.settled(Odometry, start=0.0, time=1.0, robot=robots, **columns)
    assert told(settled) == told(Odometry(0.0, 1.0, robots, **columns))
    frame = {"time": 1.0, "odometry": None, "measurements": (), "truth": None}
    assert vars(records.settled(Frame, **frame)) == vars(Frame(**frame))
