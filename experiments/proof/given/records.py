"""What the records of a log say, in exact numbers, as strictly as the filter's own reader takes them. Standard library only."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from experiments.proof.exact import Vector
from experiments.proof.given.driven import Part
from experiments.proof.given.frame import MATES, Behind, Place, Pose, Reading, Who, Within
from experiments.proof.given.head import FIRST, Head, fields_of, point
from experiments.proof.given.sensors import CENTRE, Mount
from experiments.proof.motion import Piece
from experiments.proof.reading import Broken, Record, number

DRIVEN = ("distance", "distance_bound", "turn", "turn_bound", "direction_bound", "slip_bound")
TWIST = ("speed", "speed_bound", "turn_rate", "turn_rate_bound", "direction_bound", "slip_rate")
ASIDE, HOLD = "aside", "hold"  # the first need not be there
LASTING = ("direction_bound", ASIDE)  # what does not grow with time
# The columns of each record; what is in POSITIVE is not negative.
COLUMNS = {
    "odometry": DRIVEN,
    "twist": (*TWIST, HOLD),
    "compass": ("heading", "bound"),
    "bearing": ("bearing", "bound"),
    "range": ("range", "bound", "relative_bound"),
    MATES: ("heading", "bound"),
}
OF_TARGETS = ("bearing", "range", MATES)
MEASURED = ("compass", *OF_TARGETS)
TURNED = {"compass": (-1, 0), "bearing": (1, 0), "range": (0, 0), MATES: (1, -1)}  # how angles of sensors and tags count
POSITIVE = {"distance_bound", "turn_bound", "speed_bound", "turn_rate_bound", "direction_bound", "slip_bound", "slip_rate"}
POSITIVE |= {"bound", "relative_bound", "range", HOLD}
LATER = ("twist", "position", MATES, "initial", "leave")  # kinds of records that version 1 does not have
Numbers = dict[str, Fraction]


def parts_of(head: Head, kind: str, record: Record) -> Iterator[tuple[int, Part]]:
    """Yield each robot's odometry, or its twist, which is as odometry for as long as it holds."""
    other = {"time", "robot", *(("start",) if kind == "odometry" else ())}
    for robot, _, _, told in _rows(head, kind, record, other, {ASIDE} if head.version > FIRST else set()):
        values, time = {ASIDE: Fraction(0), **told}, number(record["time"])
        if kind == "odometry":
            yield robot, Part(number(record["start"]), time, Piece(*[values[name] for name in (*DRIVEN, ASIDE)]), steady=False)
            continue
        end = time + float(values[HOLD])  # as a float, which stamps are
        last = Fraction(end) - Fraction(time)
        grown = [values[name] * (1 if name in LASTING else last) for name in (*TWIST, ASIDE)]
        yield robot, Part(time, end, Piece(*grown), steady=True)


def readings_of(head: Head, kind: str, record: Record) -> Iterator[tuple[Who, Reading]]:
    """Yield who measured of whom, and what.

    Where a bound is a pair, low and high, the error lies between these: the value then is the middle of what is true. What a
    sensor says that does not look forward is turned, and less sure by what its angle can be off.
    """
    of_mates = {"target"} if kind == MATES else set()
    may = {"target", "landmark"} if kind in ("bearing", "range") else set()
    if head.version > FIRST:
        may |= {"sensor", "target_sensor"} if kind in OF_TARGETS else {"sensor"}
    for robot, target, (own, other), values in _rows(head, kind, record, {"time", "robot", *of_mates}, may):
        share, (sign, back) = values.get("relative_bound", Fraction(0)), TURNED[kind]
        if share >= 1:
            raise Broken("a relative bound of 1 or more")
        if target == robot:
            raise Broken("a target other than the robot that measures was expected")
        value = values[COLUMNS[kind][0]] + sign * own.angle + back * other.angle
        bound = values["bound"] + abs(sign) * own.angle_off + abs(back) * other.angle_off
        yield (kind, robot, target), Reading(value, bound, share, own, other)


def _rows(
    head: Head, kind: str, record: Record, other: set[str], may: set[str]
) -> Iterator[tuple[int, int | None, tuple[Mount, Mount], Numbers]]:
    """Yield robot, target, how the sensors are mounted, and numbers of each row of a record."""
    fields_of(record, kind, {*COLUMNS[kind], *other}, may)
    names = [*COLUMNS[kind], *({ASIDE} & set(record))]
    who = [record["robot"], *(record.get(name) for name in ("target", "landmark", "sensor", "target_sensor"))]
    values = [record[name] for name in names]
    if head.version > FIRST and kind in MEASURED and not any(isinstance(value, list) for value in _all_but_bound(record)):
        values = [[value] if name == "bound" else value for name, value in zip(names, values, strict=True)]
    for robot, mate, mark, own, tag, *row in _columns([*who, *values], alike=head.version > FIRST):
        target = head.target(mate, mark) if kind in OF_TARGETS else None
        if tag is not None and mate is None:
            raise Broken("a target_sensor on a robot was expected: landmarks are where they are")
        mounts = head.mounts.of(own), CENTRE if tag is None else head.mounts.of(tag)
        yield head.robot(robot), target, mounts, _numbers(kind, dict(zip(names, row, strict=True)), head.version > FIRST)


def _all_but_bound(record: Record) -> Iterator[Any]:
    return (value for name, value in record.items() if name != "bound")


def _numbers(kind: str, row: dict[str, Any], pairs: bool) -> Numbers:
    """Return the numbers of a row; a bound may be a pair, if there are such."""
    bound = row.get("bound")
    if isinstance(bound, list) and pairs:
        low, high = (Fraction(number(end)) for end in bound)
        if low > high:
            raise Broken("a pair of bounds, the lower one first, was expected")
        value = Fraction(number(row[COLUMNS[kind][0]])) - (low + high) / 2
        rest = {name: Fraction(number(one, 0)) for name, one in row.items() if name == "relative_bound"}
        return {COLUMNS[kind][0]: value, "bound": (high - low) / 2, **rest}
    return {name: Fraction(number(value, 0 if name in POSITIVE else None)) for name, value in row.items()}


def _columns(values: Sequence[Any], alike: bool) -> Iterator[tuple[Any, ...]]:
    """Return columns of one length as rows; a value that is no list stands for all, and without `alike` a list of one, too."""
    single = [value[0] if not alike and isinstance(value, list) and len(value) == 1 else value for value in values]
    lengths = {len(value) for value in single if isinstance(value, list)}
    if len(lengths) > 1:
        raise Broken("columns of one length were expected")
    rows = lengths.pop() if lengths else 1
    return zip(*(value if isinstance(value, list) else [value] * rows for value in single), strict=True)


def places_of(head: Head, record: Record) -> Iterator[tuple[int, int, Place]]:
    """Yield robots, the numbers of their sensors, -1 for the centre, and where these are, by a position in one of its forms."""
    if "normal_x" in record:
        fields_of(record, "position", {"time", "robot", "normal_x", "normal_y", "offset"}, {"sensor"})
        columns = [record["robot"], record.get("sensor"), *(record[name] for name in ("normal_x", "normal_y", "offset"))]
        for robot, sensor, x, y, offset in _columns(columns, alike=True):
            yield head.robot(robot), head.mounts.number(sensor), Behind(point((x, y)), Fraction(number(offset)))
        return
    forms = ({"vertices"}, {"normal", "offset"}, {"position", "radius"}, {"position", "bound"})
    form = next((form for form in forms if form <= set(record)), forms[-1])
    fields_of(record, "position", {"time", "robot", *form}, {"sensor"})
    yield head.robot(record["robot"]), head.mounts.number(record.get("sensor")), _place(record)


def _place(record: Record) -> Place:
    if "vertices" in record:
        corners = [point(corner) for corner in record["vertices"]]
        if not corners:
            raise Broken("a position without a point")
        return Within(corners)
    if "normal" in record:
        normal = point(record["normal"])
        if not any(normal):
            raise Broken("a normal with a direction was expected")
        return Behind(normal, Fraction(number(record["offset"])))
    x, y = point(record["position"])
    if "radius" in record:
        return Within([(x, y)], Fraction(number(record["radius"], 0)))
    bound = record["bound"]
    wide, high = (Fraction(number(one, 0)) for one in (bound if isinstance(bound, list) else (bound, bound)))
    return Within([(x - wide, y - high), (x + wide, y - high), (x + wide, y + high), (x - wide, y + high)])


def truth_of(head: Head, record: Record) -> dict[int, Pose]:
    """Return where robots were and which way they looked, as far as the log tells."""
    if head.version > FIRST and "positions" not in record:
        fields_of(record, "truth", {"time", "robot", "position", "heading"})
        return {head.robot(record["robot"]): (_known(record["position"]), _looks(record["heading"]))}
    fields_of(record, "truth", {"time", "positions", "headings"})
    places, ways = record["positions"], record["headings"]
    if not len(places) == len(ways) == head.robots:
        raise Broken(f"one truth of {head.robots} robots was expected")
    if head.version == FIRST and None in (*places, *ways):
        raise Broken("a truth that is known was expected")
    return {robot: (_known(place), _looks(way)) for robot, (place, way) in enumerate(zip(places, ways, strict=True))}


def _known(place: Any) -> Vector | None:
    return None if place is None else point(place)


def _looks(way: Any) -> Fraction | None:
    return None if way is None else Fraction(number(way))
