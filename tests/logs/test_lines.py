"""The two readers of a log's lines: what the fast one accepts the strict one accepts, and they give the same record."""

import json
import re
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.logs import Header, records
from experiments.logs.reading.fast import Fast
from experiments.logs.reading.fields import Fields
from experiments.logs.reading.strict import Strict
from filter import Frame, InvalidInput, Odometry, Sensor, Team

MARKS, ARENA = [[0.5, 1.0], [-2.0, 1.5]], [[-6, -6], [6, 6]]
SENSORS = [Sensor("camera", [0.1, 0]), Sensor("tag")]
TEAM = Team(["alice", "bob", "3"], dict(zip(["gate", "door"], MARKS, strict=True)), arena=ARENA, sensors=SENSORS)
HEADERS = {1: Header(Team(3, MARKS, arena=ARENA), 0.0), 2: Header(TEAM, 0.0)}
FAST = {version: Fast(header) for version, header in HEADERS.items()}
STRICT = {version: Strict(header) for version, header in HEADERS.items()}
versions = st.sampled_from([1, 2])
SPELLINGS = ("{!r}", "{:.3e}", "{:.1f}", "{:.0f}", "{:+.17E}")
TURN = 2 * np.pi
LIMITS = [0.0, -0.0, 5e-324, 1.0, np.pi / 2, np.pi, 1e100]
EDGES = sorted({float(near) for edge in LIMITS for near in (edge, np.nextafter(edge, 0), np.nextafter(edge, np.inf))})


@st.composite
def numbers(draw, low=-1e100, high=1e100):
    """Numbers within a field's limits, as people and programs spell them."""
    value = draw(st.one_of(st.sampled_from([each for each in EDGES if low <= each <= high]), st.floats(low, high)))
    texts = [spelling.format(value).replace("+", "", 1) for spelling in SPELLINGS]
    texts += ["-0", "1e-3", "0.5"]
    return draw(st.sampled_from([text for text in texts if low <= float(text) <= high]))


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
    "twist": {
        "speed": ANY,
        "speed_bound": POSITIVE,
        "turn_rate": ANY,
        "turn_rate_bound": POSITIVE,
        "direction_bound": BELOW_90,
        "slip_rate": POSITIVE,
        "hold": numbers(1e-6, 1e100),
    },
    "compass": {"heading": numbers(-TURN, TURN), "bound": numbers(0, np.pi)},
    "bearing": {"bearing": numbers(-TURN, TURN), "bound": numbers(0, np.pi)},
    "range": {"range": POSITIVE, "bound": POSITIVE, "relative_bound": numbers(0, 0.9999999999999999)},
    "relative_heading": {"heading": numbers(-TURN, TURN), "bound": numbers(0, np.pi)},
}
SIGHTED = ("bearing", "range", "relative_heading")


def listed(tokens):
    return f"[{', '.join(tokens)}]"


def column(values, count):
    """A column of one length, or one number for all of it."""
    return st.one_of(values, st.lists(values, min_size=count, max_size=count).map(listed))


@st.composite
def sighted(draw, count, heads):
    """The columns of robots and of those that they see, another robot or a landmark each; of what has a heading, robots."""
    robots = draw(st.lists(st.integers(0, 2), min_size=count, max_size=count))
    mates = [draw(st.sampled_from([*([] if heads else [None]), *({0, 1, 2} - {robot})])) for robot in robots]
    marks = [draw(st.integers(0, 1)) if mate is None else None for mate in mates]
    seen = {"target": mates} if heads else {"target": mates, "landmark": marks}
    if not heads and draw(st.booleans()):
        seen = {name: bodies for name, bodies in seen.items() if any(body is not None for body in bodies)} or {"target": []}
    told = {name: listed("null" if body is None else str(body) for body in bodies) for name, bodies in seen.items()}
    alone = count == 1 and draw(st.booleans())
    return {name: text.strip("[]") if alone else text for name, text in {"robot": str(robots), **told}.items()}


SENSOR = st.sampled_from(["0", "1", "null", '"camera"', '"tag"'])
NAMES = {"robot": ["alice", "bob", "3"], "target": ["alice", "bob", "3"], "landmark": ["gate", "door"]}


@st.composite
def lines(draw, version):
    """The fields of a line, as text."""
    kind = draw(
        st.sampled_from([*(["compass", "odometry", "bearing", "range"] if version == 1 else COLUMNS), "truth", "frame"])
    )
    fields = {"record": f'"{kind}"', "time": draw(ANY)}
    if kind == "truth":
        points = [listed([draw(ANY), draw(ANY)]) for _ in range(3)]
        fields |= {"positions": listed(points), "headings": listed([draw(ANY) for _ in range(3)])}
    if kind in COLUMNS:
        count = draw(st.integers(0, 3))
        moved = str(draw(st.permutations(range(3)))[:count])
        fields |= {"start": "-1e100"} if kind == "odometry" else {}
        fields |= {"robot": moved if kind in ("odometry", "twist") else str([0] * count)}
        fields |= draw(sighted(count, kind == "relative_heading")) if kind in SIGHTED else {}
        fields |= {name: draw(column(values, count)) for name, values in COLUMNS[kind].items()}
    if version == 2:
        fields |= draw(second(kind, fields))
    order = draw(st.permutations(list(fields)))
    return [(name, fields[name]) for name in order]


@st.composite
def second(draw, kind, fields):
    """What version 2 has in the place of some fields: names, pairs, and where a robot drives."""
    changed = {}
    for name in ({"robot", "target", "landmark"} & set(fields)) if draw(st.booleans()) else ():
        changed[name] = re.sub(r"\d+", lambda number, name=name: f'"{NAMES[name][int(number[0])]}"', fields[name])
    if kind in ("odometry", "twist") and draw(st.booleans()):
        changed["aside"] = draw(numbers(-2 * np.pi, 2 * np.pi))
    if kind in ("compass", *SIGHTED) and draw(st.booleans()):
        changed["sensor"] = draw(column(SENSOR, fields["robot"].count(",") + (fields["robot"] != "[]")))
    if "target" in fields and "landmark" not in fields and draw(st.booleans()):
        changed["target_sensor"] = draw(column(SENSOR, fields["robot"].count(",") + (fields["robot"] != "[]")))
    alone = not any(value.startswith("[") for name, value in (fields | changed).items() if name not in ("record", "bound"))
    bound = fields.get("bound", "[]")
    if bound != "[]" and (draw(st.booleans()) or (alone and bound.startswith("["))):  # alone, a list is a pair
        pair = numbers(-0.5, 0.25), numbers(0.5, 1)
        count = fields["bound"].count(",") + 1 if fields["bound"].startswith("[") else 0
        some = [listed([draw(each) for each in pair]) if draw(st.booleans()) else "0.5" for _ in range(count)]
        changed["bound"] = listed(some) if count else fields["bound"]
        if alone:
            changed["bound"] = listed([draw(each) for each in pair])
    return changed


def text_of(fields, comma=", ", colon=": "):
    return ("{" + comma.join(f'"{name}"{colon}{value}' for name, value in fields) + "}\n").encode()


def strict(text, version=1):
    """Return what the strict reader says, None for a refusal."""
    try:
        return STRICT[version].read(Fields.parse(text))
    except InvalidInput:
        return None


def same(text, version):
    """Return whether the strict reader accepts what the fast one accepts, and gives the same."""
    slowly, fast = strict(text, version), FAST[version].read(text)
    return fast is None or (slowly is not None and told(fast) == told(slowly))


def told(record):
    """Return all that a record is, to the last bit."""
    values = (
        record._asdict() if isinstance(record, tuple) else {each.name: getattr(record, each.name) for each in fields(record)}
    )
    return type(record), {name: _told(value) for name, value in values.items()}


def _told(value):
    if isinstance(value, np.ndarray):
        return value.dtype, value.shape, value.tobytes(), value.flags.writeable, value.flags.owndata
    return told(value) if hasattr(value, "__dict__") else (type(value), np.float64(value).tobytes())


@settings(max_examples=200)
@given(versions, st.data(), st.sampled_from([", ", ",", " ,\t"]), st.sampled_from([": ", ":", " : "]))
def test_the_fast_reader_gives_what_the_strict_one_gives(version, data, comma, colon):
    text = text_of(data.draw(lines(version)), comma, colon)
    slowly, fast = strict(text, version), FAST[version].read(text)
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
LATER = [
    {"record": "odometry", "start": 0.5, "time": 1, "robot": 1, **dict.fromkeys(COLUMNS["odometry"], 0.25), "aside": 1.5},
    {"record": "range", "time": 1, "robot": 0, "landmark": 1, "range": 1e100, "bound": [-1, 1], "relative_bound": 0},
    {"record": "odometry", "start": 0.5, "time": 1, "robot": "bob", **dict.fromkeys(COLUMNS["odometry"], 0.25), "aside": 1.5},
    {"record": "twist", "time": 1, "robot": "bob", **dict.fromkeys(COLUMNS["twist"], 0.25)},
    {"record": "twist", "time": 1, "robot": ["bob", 2], **{name: [0.25, 1] for name in COLUMNS["twist"]}, "aside": [0, 1]},
    {"record": "compass", "time": 1, "robot": "bob", "heading": 0.25, "bound": [-0.5, 0.1]},
    {"record": "compass", "time": 1, "robot": ["alice", 1], "heading": 0.25, "bound": [0.5, 0.1]},
    {"record": "bearing", "time": 1, "robot": "alice", "landmark": "gate", "bearing": 0.25, "bound": [0.25, 0.5]},
    {
        "record": "bearing",
        "time": 1,
        "robot": [0, "3"],
        "target": [None, "bob"],
        "landmark": [0, None],
        "bearing": 1,
        "bound": [0, 1],
    },
    {"record": "range", "time": 1, "robot": 0, "target": "bob", "range": 0.25, "bound": [0, 0.75], "relative_bound": 0},
    {
        "record": "range",
        "time": 1,
        "robot": 0,
        "target": [1, 2],
        "range": 4,
        "bound": [[0, 0.5], 0],
        "relative_bound": [0.1, 0],
    },
    {"record": "compass", "time": 1, "robot": "bob", "heading": 0.25, "bound": 0.1, "sensor": "tag"},
    {"record": "compass", "time": 1, "robot": [0, 1], "heading": 0.25, "bound": [0.1, 0.2], "sensor": [None, 1]},
    {"record": "bearing", "time": 1, "robot": 0, "target": "bob", "bearing": 1, "bound": 0.5, "target_sensor": "tag"},
    {
        "record": "range",
        "time": 1,
        "robot": 0,
        "target": [1, None],
        "landmark": [None, 1],
        "range": 4,
        "bound": [[0, 0.5], 0],
        "relative_bound": 0,
        "sensor": 0,
        "target_sensor": ["tag", None],
    },
    {"record": "relative_heading", "time": 1, "robot": 2, "target": "bob", "heading": 0.25, "bound": [-0.5, 0.1]},
    {
        "record": "relative_heading",
        "time": 1,
        "robot": [0, 2],
        "target": ["bob", 1],
        "heading": [0.25, 1],
        "bound": [0.1, [0, 1]],
        "sensor": 0,
        "target_sensor": [None, "tag"],
    },
    {"record": "position", "time": 1, "robot": "bob", "position": [0.1, 1e99], "bound": 0.3},
    {"record": "position", "time": 1, "robot": 0, "position": [0.1, -7], "bound": [0.3, 0]},
    {"record": "position", "time": 1, "robot": 0, "position": [0.1, -7], "bound": 0.3, "sensor": "tag"},
    {"record": "position", "time": 1, "robot": 0, "position": [0.1, -7], "bound": 0.3, "sensor": None},
    {"record": "truth", "time": 1, "robot": "bob", "position": [0, 1], "heading": None},
    {"record": "truth", "time": 1, "robot": 2, "position": None, "heading": 1},
    {"record": "truth", "time": 1, "positions": [[0, 1], None, [7, 7]], "headings": [0, None, 2.5]},
]
NUMBERS = [sign + repr(edge) for edge in EDGES for sign in ("", "-")] + ["9" * 400]
NUMBERS += ["2", "6.5", "-6.5", "3", "1e101", "1e999", "01", "1.", ".5"]
OTHERS = """
    "camera" ["camera",null] [null,"tag"]
    true null "1" "a:b" NaN -Infinity [] {} {"a":1} "bob" "gate" "3" ["alice",2] ["door",null] ["bob","bob"] "frame"
    "compass" "range" "relative_heading"
"""
BODIES = """
    [0] [3] [0,0] [0,1] [1,0] [0,3] [0,-1] [1,0,2] [0,null,null] [null,0] [0,null] [null,null] [1.0,0] [true,0]
"""
LISTS = """
    [-0.1,0.1] [0.1,2] ["1",0] [[0,1]] [[0,1],[0,1],[0]] [[0,1],[0,1],[0,1],[0,1]] [[0,null],[0,null],[0,null]]
    [0.5,0.5,0.5,0.5]
"""
PAIRS = """
    [[0,1],[-1,1]] [[0,1],0.5] [[1,0],0] [[0,1,2],0] [[0],0] [0.5,-0.1] [[-9,9],0] [[],[]] [1e+100,1e+100]
    [-1e+100,-1e+99]
"""
JUNK = NUMBERS + (OTHERS + BODIES + LISTS + PAIRS).split()


def changes(fields):
    """Yield the fields with one of them changed, left out, there twice or too many."""
    for place, (name, value) in enumerate(fields):
        before, after = fields[:place], fields[place + 1 :]
        yield from ([*before, (name, junk), *after] for junk in JUNK)
        yield from ([*before, *after], [*fields, (name, value)], [*before, (name.upper(), value), *after])
    yield from (
        [*fields, (name, junk)]
        for name in ("target", "landmark", "positions", "headings", "sigma", "sensor", "target_sensor")
        for junk in ("0", "null", "[0, 1]")
    )


@pytest.mark.parametrize(
    ("version", "base"),
    [*((1, base) for base in BASES), *((2, base) for base in BASES + LATER)],
    ids=lambda each: each["record"] if isinstance(each, dict) else None,
)
def test_what_the_strict_reader_refuses_the_fast_one_refuses(version, base):
    fields = [(name, json.dumps(value)) for name, value in base.items()]
    assert FAST[version].read(text_of(fields)) is not None
    texts = [text_of(changed) for changed in changes(fields)]
    assert [text for text in texts if not same(text, version)] == []
    assert sum(strict(text, version) is None for text in texts) > len(JUNK) / 2


@pytest.mark.parametrize("base", LATER, ids=lambda base: base["record"])
def test_version_1_knows_nothing_of_version_2(base):
    text = json.dumps(base).encode()
    assert FAST[1].read(text) is strict(text, 1) is None


def test_two_bounds_are_two_measurements_in_version_1_and_a_pair_in_version_2():
    text = b'{"record": "compass", "time": 1, "robot": 0, "heading": 0.25, "bound": [0, 0.5]}'
    assert [FAST[version].read(text).bound.tolist() for version in (1, 2)] == [[0.0, 0.5], [0.25]]
    assert FAST[2].read(text).heading.tolist() == [0.0]


@pytest.mark.parametrize("robots", [2, 4])
def test_the_truth_of_too_few_or_too_many_is_refused_by_both(robots):
    truth = {"record": "truth", "time": 1, "positions": [[0, 0]] * robots, "headings": [0] * robots}
    assert all(strict(json.dumps(truth).encode(), v) is FAST[v].read(json.dumps(truth).encode()) is None for v in FAST)


@pytest.mark.parametrize("version", [1, 2])
def test_degrees_are_refused_by_both_and_a_yaw_that_was_never_wrapped_by_none(version):
    def read(record, bound, **fields):
        text = json.dumps({"record": record, "time": 1, "robot": 0, "bound": bound, **fields}).encode()
        return strict(text, version), FAST[version].read(text)

    assert read("bearing", 0.1, landmark=0, bearing=45.0) == (None, None)
    assert read("compass", 2.0, heading=350.0) == (None, None)
    slowly, fast = read("compass", 0.1, heading=350.0)
    assert told(slowly) == told(fast)
    slowly, fast = read("bearing", 0.4, landmark=0, bearing=-12.5)
    assert told(slowly) == told(fast)
    assert read("relative_heading", 0.1, target=1, heading=-90.0) == (None, None)
    slowly, fast = read("relative_heading", 0.4, target=1, heading=-12.5)
    assert (slowly is fast is None) if version == 1 else told(slowly) == told(fast)


@settings(max_examples=300)
@given(versions, st.data(), st.integers(0, 10_000), st.integers(0, 255))
def test_a_byte_that_flips_makes_no_difference_between_the_readers(version, data, place, byte):
    text = bytearray(text_of(data.draw(lines(version))))
    text[place % len(text)] = byte
    assert same(bytes(text), version)


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("text", [b"[" * 100_000, b'{"record":' * 100_000, b'{"record": "frame", "time": ' + b"[" * 100_000])
def test_endless_nesting_is_refused_by_both(text, version):
    assert strict(text, version) is FAST[version].read(text) is None


def test_what_is_settled_is_what_the_public_constructor_makes():
    columns = {name: np.arange(2.0) / 4 for name in (*COLUMNS["odometry"], "aside")}
    for values in columns.values():
        values.setflags(False)
    robots = np.arange(2)
    robots.setflags(False)
    settled = records.settled(Odometry, start=0.0, time=1.0, robot=robots, **columns)
    assert told(settled) == told(Odometry(0.0, 1.0, robots, **columns))
    frame = {"time": 1.0, "odometry": None, "measurements": (), "truth": None, "changes": ()}
    assert vars(records.settled(Frame, **frame)) == vars(Frame(**frame))
