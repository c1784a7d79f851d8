"""When what a suspect says has agreed with all else for so long, and so variously, that it is believed: evidence, no proof."""

from filter.arrays import Array
from filter.diagnosis.told import Who
from filter.linear.sources import NOBODY
from filter.sets.belief import Used
from filter.sets.suspect import Suspect

INSTANTS = 10  # at so many instants at least has it spoken
METRES = 3.0  # so far has its robot driven: a turned camera agrees with itself until then [m]
BODIES, OFTEN = 2, 5  # so many different ones were seen by its robot, or have seen it, each at so many instants
AGAIN = 2  # who was found guilty is trusted again after so many times that


def is_enough(suspect: Suspect, used: Used, metres: Array, times: int = 1) -> bool:
    """Return whether what was merged of a suspect's without a conflict, over (n,) metres driven since [m], acquits it.

    If times are said, it has to have spoken, and driven, so many times as often and as far.
    """
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
