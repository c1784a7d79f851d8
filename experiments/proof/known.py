"""What is proved of each frame so far, and of rows that follow from that later. Exact arithmetic, standard library only."""

from collections import Counter
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from fractions import Fraction
from typing import Self

from experiments.proof.cases.slices import DIRECTIONS, Slice, TakenAlong
from experiments.proof.cases.votes import Poll, Windows
from experiments.proof.edges import WORLD, Edges, all_edges, through_corner
from experiments.proof.exact import Arc, Vector, steps
from experiments.proof.given.frame import Frame
from experiments.proof.given.log import Log
from experiments.proof.measured import Instant
from experiments.proof.motion import Displaced, turned
from experiments.proof.reading import Broken
from experiments.proof.share import Share
from experiments.proof.sides import Sides

Told = dict[int, TakenAlong]  # of robots
BACK = 16  # an alternative begins so many frames ago at most; of earlier ones less is kept


class Known:
    """What is known of frames, one after the other; others can branch off.

    Attributes:
        links: How many links of each kind there were, all of them proved, in this process's share.
        is_voted: Whether sightings are votes.
        windows: How long these were.
        is_empty: Whether it was claimed in the last step that nothing is possible.
        shown: What the last step's certificates have proved of each robot and pair, after all that its headings rest on.
    """

    def __init__(self, log: Log, share: Share | None = None, *, is_voted: bool = False) -> None:
        """Take what was given to the filter, whose share it is, and whether sightings count as votes alone."""
        self._share, self.is_voted, self.windows = share or Share(), is_voted, Windows()
        self._is_mine, self._is_torn = True, False  # whether to prove what is claimed now; whether no case is left in this step
        self.links: Counter[str] = Counter()
        self.is_empty = False
        self.shown: Edges = {}
        self._log = log
        self._since = 0  # so many frames are known of other cases, too: none can branch off there
        self._numbers = {frame.time: number for number, frame in enumerate(log.frames)}
        self._placed = [0] * log.robots  # at which frame each robot was put somewhere: nothing from before counts
        self._ended: dict[int, tuple[list[int], Told]] = {}  # that, and slices, when each of the last frames began
        self._history: list[list[Displaced]] = []  # by frames, as are the next two
        self._proved: list[Edges] = []
        self._instants: list[Instant] = []
        self._grown: dict[tuple[int, int, Vector, int], tuple[int, Fraction]] = {}  # up to which frame, and by how much
        self._seen: set[str] = set()
        self._slices: Told = {}
        self._polls: dict[int, Poll] = {}  # of robots
        self._heard = Frame(0.0)  # the last frame, with all that counts as votes
        self._looks: list[Arc] = []  # what is proved of the headings, which can be more than is claimed
        self._told: tuple[list[Arc], list[Arc]] = [], []  # these, and what is left of them by what `_looking` takes

    @property
    def frames(self) -> int:
        """How many frames there were."""
        return len(self._history)

    def branch(self, frames: int) -> Self:
        """Return one that goes on after so many frames; of what came later it knows nothing. Links are counted together."""
        if frames < self._since:
            raise Broken("something that goes on from before several cases were one")
        other, is_now = copy(self), frames == self.frames
        other._history, other._proved, other._instants = self._history[:frames], self._proved[:frames], self._instants[:frames]
        if not is_now:
            other._placed, other._slices = self._ended[frames]
        other._ended, other._grown = dict(self._ended), dict(self._grown) if is_now else {}
        return other

    def begun(self, headings: Sequence[Arc], edges: Edges, slices: Told | None = None) -> Self:
        """Return one of which at the last frame that is known, and slices, and nothing else."""
        other, now = self.branch(self.frames), self.frames - 1
        nothing = Frame(self._instants[now].frame.time)
        other._instants[now] = Instant(self._log, nothing, headings, Sides(self._log.robots, self._log.landmarks), edges)
        other._proved[now], other.shown, other._slices, other._placed = edges, edges, slices or {}, [now] * self._log.robots
        other._since = self.frames
        return other

    def again(self, frame: Frame) -> Self:
        """Return the same, to go on with what else was heard at the last frame; its robots are where they were put then."""
        other, now = self.branch(self.frames), self.frames - 1
        frame = replace(self._instants[now].frame, readings=frame.readings, places=frame.places)
        other._proved[now] = {pair: dict(edges) for pair, edges in self._proved[now].items()}
        other._instants[now] = replace(self._instants[now], frame=frame, sides=self.sides.copy(), edges=other._proved[now])
        other._slices, other._looks, other._seen, other._told = dict(self._slices), list(self.headings), set(), ([], [])
        return other

    @property
    def headings(self) -> Sequence[Arc]:
        """What has been proved of the robots' headings in this step so far."""
        return self._instants[-1].headings

    @property
    def sides(self) -> Sides:
        """Where targets are, as far as that has been proved in this step."""
        return self._instants[-1].sides

    @property
    def edges(self) -> Edges:
        """What has been proved of each robot and pair in this step so far."""
        return self._proved[-1]

    def _begin(self, frame: Frame) -> Frame:
        log, number, self._heard = self._log, self.frames, frame.only("compass", "bearing", "range")
        frame = frame.only("compass") if self.is_voted else frame
        self._ended = {then: each for then, each in self._ended.items() if number - BACK < then < number}
        self._ended[number] = [*self._placed], self._slices
        self._grown = {row: grown for row, grown in self._grown.items() if number - BACK < grown[0]}
        self._placed, self.is_empty = [*self._placed], False
        before = self.headings if number else [start.heading for start in log.starts]
        driven = list(zip(frame.pieces, before, strict=True))
        self._history.append([Displaced.of(*each) for each in driven] if any(frame.pieces) else [])
        self._proved.append({})
        looks, sides = [turned(*each) for each in driven], Sides(log.robots, log.landmarks, log.mounts)
        self._slices = {robot: told for robot, told in self._slices.items() if robot not in frame.placed}
        self._polls = {robot: poll for robot, poll in self._polls.items() if robot not in frame.placed}
        for robot, start in frame.placed.items():
            looks[robot], self._placed[robot] = start.heading, number
        self._instants.append(Instant(log, frame, looks, sides, self.edges))
        self._seen, self._looks, self._told = set(), list(self.headings), ([], [])
        return frame

    def slices_of(self, robot: int) -> list[Slice]:
        """Return the slices of a robot's poses that were told last, as they are now; none if there are none."""
        return self._now(robot, self._slices[robot]) if robot in self._slices else []

    def around(self, robot: int) -> list[Slice]:
        """Return one slice around the poses of a robot, as shown in this step; none if its edges are not around it."""
        edges = self.shown.get((WORLD, robot), {})
        reach = [through_corner(edges, normal) for normal in DIRECTIONS]
        return [] if None in reach else [Slice(self.headings[robot], [steps(far) for far in reach if far is not None])]

    def _now(self, robot: int, told: TakenAlong) -> list[Slice]:
        """Return slices of a robot's poses as they are now."""
        return told.at(self.frames - 1, lambda frame: self._instants[frame].frame.pieces[robot])

    def _support(self, number: int, body: int, normal: Vector) -> Fraction:
        motions = self._history[number]
        return motions[body].support(normal) if motions else Fraction(0)

    def _number(self, time: float) -> int:
        """Return the number of the frame of a time [s]."""
        number = self._numbers.get(time, len(self._proved))
        if number >= len(self._proved):
            raise Broken(f"a row of t = {time} s, which is no frame so far")
        return number

    def _of_edges(self, pair: tuple[int, int], normal: Vector, offset: Fraction, taken: int) -> str | None:
        """Return why a row holds, if it is an edge proved in this step or in one before, or goes through a corner."""
        edge = self.edges.get(pair, {}).get(normal)
        if edge is not None and edge <= offset:
            return "rows that are edges proved in the same step"
        before = self._proved[taken] if taken >= 0 else {}
        grown = self._growth((*pair, normal, taken)) if pair in before else None
        if grown is None:
            return None
        then = offset - grown
        edge = before[pair].get(normal)
        if edge is not None and edge <= then:
            return "rows that are edges of an earlier step, moved"
        corner = through_corner(all_edges(before, pair), normal, then)
        return "rows through corners of an earlier step, moved" if corner is not None and corner <= then else None

    def _growth(self, row: tuple[int, int, Vector, int]) -> Fraction | None:
        """Return how much a row has moved outward since the frame that it was measured or proved at.

        None if one of its robots was put somewhere since: of where it is now the row says nothing.
        """
        i, j, normal, taken = row
        if taken < max(self._placed[body] for body in (i, j) if body >= 0):
            return None
        number, total = self._grown.get(row, (taken, Fraction(0)))
        back = (-normal[0], -normal[1])
        for later in range(number + 1, len(self._history)):
            total += self._support(later, j, normal) + (self._support(later, i, back) if i >= 0 else 0)
        self._grown[row] = len(self._history) - 1, total
        return total
