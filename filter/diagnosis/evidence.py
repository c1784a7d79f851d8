"""When what a suspect says has agreed with all else for so long, and so variously, that it is believed: evidence, no proof."""

from collections import Counter

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.cameras.offsets import Offsets
from filter.diagnosis.told import Records, Who, said, some
from filter.linear.sources import NOBODY
from filter.sensing.readings import targets_of
from filter.sets.belief import Belief, Used
from filter.sets.suspect import Suspect

TEST = 4  # a test counts for so many instants: all else tells enough then to contradict what is said
INSTANTS = 10 * TEST  # at so many instants at least has it spoken, in tests at fewer
METRES = 3.0  # so far has its robot driven: a turned camera agrees with itself until then [m]
BODIES, OFTEN = 2, 5 * TEST  # so many different ones were seen by its robot, or have seen it, each at so many instants
AGAIN = 2  # who was found guilty is trusted again after so many times that
EXCHANGED = 7  # an instant counts for so many if markers are taken as exchanged: as that says where they are
FITS = 10  # at so many instants in a row has what it says fitted what is known without it
PLACE, HEADING = 0.5, np.radians(15)  # a pose known as well as this contradicts what is grossly wrong [m], [rad]


def counted(used: Used, records: Records, tests: Records) -> Used:
    """Return at how many instants each has said something, with one more; more yet for who has said something in a test."""
    return Counter(used) + Counter(said(records)) + Counter(dict.fromkeys(said(tests), TEST - 1))


def put_to_test(records: Records, known: Belief) -> Records:
    """Return those readings that what is known already could contradict if they were grossly wrong.

    Whoever measures knows its pose, and of a mate that it measures the place is known, to within `PLACE` and `HEADING`; or it
    has a camera that an estimate vouches for, which would tell, too.
    """
    placed = np.max(known.polytope.upper - known.polytope.lower, axis=1) <= PLACE
    knows = placed & (known.headings.bound <= HEADING)
    knows = knows if known.cameras is None else knows | known.cameras.vouched
    left = (some(each, knows[each.robot] & _placed(targets_of(each), placed)) for each in records)
    return tuple(record for record in left if record is not None)


def _placed(target: Integers, placed: Mask) -> Mask:
    """Return (k,) whether the places of targets are known, as those of landmarks are."""
    is_mate = (target != NOBODY) & (target < len(placed))
    return ~is_mate | placed[np.where(is_mate, target, 0)]


def vouched_for(metres: Array, cameras: Offsets | None) -> Array:
    """Return metres (n,) that robots have driven [m]: enough where an estimate vouches for the camera, if there is one."""
    return metres if cameras is None else np.where(cameras.vouched, np.maximum(metres, METRES), metres)


def is_enough(suspect: Suspect, used: Used, metres: Array, times: int = 1, *, weight: int = 1) -> bool:
    """Return whether what was merged of a suspect's without a conflict, over (n,) metres driven since [m], acquits it.

    If times are said, it has to have spoken, and driven, so many times as often and as far; every instant counts for a weight.
    """
    used = {who: weight * count for who, count in used.items()}
    if _instants(suspect, used) < times * INSTANTS:
        return False
    tested = (robot for robot in _by(suspect, used) if len(bodies_of(robot, used)) >= BODIES)
    return any(_is_tested(suspect, robot, used, metres / times) for robot in tested)


def bodies_of(robot: int, used: Used) -> set[tuple[int, int]]:
    """Return who has often seen whom, of a robot; that it was told its position counts as one."""
    often = ((who, target) for (kind, who, target), count in used.items() if kind == "sighting" and count >= OFTEN)
    return {pair for pair in often if robot in pair}


def _instants(suspect: Suspect, used: Used) -> int:
    if suspect.kind == "exchange":
        return max(used.get(("body", NOBODY, robot), 0) for robot in suspect.who[1:])
    if suspect.kind == "past":
        robot = suspect.who[1]
        return max(used.get(("sensor", robot, NOBODY), 0), used.get(("body", NOBODY, robot), 0))
    return used.get(suspect.who, 0)


def _by(suspect: Suspect, used: Used) -> list[int]:
    """Return the robots whose readings tell of a suspect."""
    if suspect.robot is not None and suspect.kind != "exchange":
        return [suspect.robot]
    targets = {suspect.target} if suspect.kind == "body" else {suspect.robot, suspect.target}
    return sorted({robot for kind, robot, target in used if kind == "sighting" and target in targets})


def _is_tested(suspect: Suspect, robot: int, used: Used, metres: Array) -> bool:
    """Return whether a robot has driven far enough, or has a second sensor, which is not the suspect."""
    seconds: list[Who] = [("compass", robot, NOBODY), ("body", NOBODY, robot), ("sighting", robot, NOBODY)]
    own = {"sensor": ("sighting", robot, NOBODY)}.get(suspect.kind, suspect.who)
    return bool(metres[robot] >= METRES) or any(used.get(who, 0) >= INSTANTS for who in seconds if who != own)
