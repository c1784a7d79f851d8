"""Whatever wrong thing is handed in, an error of ours says what was expected and what came; and no belief changes."""

import time

import numpy as np
import pytest
from helpers.wrong import NO_NUMBER, NO_NUMBERS, NO_POINTS, NO_WHOLE_NUMBER, NO_WHOLE_NUMBERS, NOT_OURS, snapshot

from filter import (
    Alignment,
    AngularIntervals,
    Bearing,
    Budget,
    Compass,
    ExtendedKalmanFilter,
    FixedLag,
    Frame,
    GaussianBelief,
    InvalidInput,
    NoiseModel,
    Odometry,
    Polygon,
    Range,
    RobustFilter,
    SetMembershipFilter,
    Stop,
    Team,
    Truth,
    Window,
    follow,
    watch,
    wrap,
)

MOST = 450  # characters of an error's text
TEAM = Team(2, [[3.0, 0.0], [0.0, 3.0]], 0.5, 1.5, [[-5, -5], [5, 5]])
BOX = Polygon.box([-1, -1], [1, 1])
ARCS = AngularIntervals([0.0, 1.0], [0.1, 0.1])
FILTERS = [SetMembershipFilter(TEAM), RobustFilter(TEAM), ExtendedKalmanFilter(TEAM)]
BELIEFS = [filter_.start(0.0, [BOX, BOX], ARCS) for filter_ in FILTERS]
(SETS, ROBUST, KALMAN), (BELIEF, _, GAUSSIAN) = FILTERS, BELIEFS
LAG = FixedLag(SETS, lambda start, end: None)
LAGGED = LAG.begin(BELIEF)
COMPASS = Compass(0, 0, 0, 0.1)
MOTION = Odometry(0, 1, [0, 1], 0.1, 0.01, 0, 0.01, 0, 0.01)


def but(wrong, *names, **more):
    """Return a table of wrong values without some, and with more of them."""
    return {key: make for key, make in wrong.items() if key not in names} | {key: lambda v=v: v for key, v in more.items()}


BOUND, SPREAD = but(NO_NUMBERS, negative=-1e-9), but(NO_NUMBER, negative=-1e-9)
LIMIT = but(BOUND, two=[0.5, 0.5], spatial=[[0.5], [0.5], [0.5]])
ABOVE_0 = but(SPREAD, zero=0.0)
COUNT = but(NO_WHOLE_NUMBER, negative=-1)
OPTION = but(NOT_OURS, "None")  # where None is right
NO_TEAM = but(NOT_OURS, kind=Team, polygon=BOX)
NO_BELIEF = but(NOT_OURS, kind=type(BELIEF), region=BELIEF.regions[0], three=RobustFilter(Team(3)).start(0, [BOX] * 3))
NO_BELIEF |= but({}, three_robots=SetMembershipFilter(Team(3)).start(0, [BOX] * 3), four=KALMAN.start(0, [BOX] * 2).mean)
NO_POLYGONS = but(NOT_OURS, alone=BOX, few=[BOX], vertices=[BOX.vertices] * 2, regions=list(BELIEF.regions))
NO_ARCS = but(
    OPTION, polygons=[BOX, BOX], few=ARCS[0], pairs=[(0.0, 0.1), (1.0, 0.1)], empty=AngularIntervals([0, 0], [0.1, -1])
)
NO_MOTION = but(OPTION, compass=COMPASS, kind=Odometry, stranger=Odometry(0, 1, 2, 0, 0, 0, 0, 0, 0))
NO_RECORDS = but(NOT_OURS, alone=COMPASS, motion=[MOTION], nested=[[COMPASS]], gap=[COMPASS, None], kind=[Compass])
NO_RECORDS |= but({}, stranger=[Compass(0, 2, 0, 0.1)], far=[Range(0, 0, 4, 1, 0.1, 0)])
NO_FRAMES = but(NOT_OURS, alone=Frame(0), records=[COMPASS], times=[0.0, 1.0])
NO_FILTER = but(NOT_OURS, kind=SetMembershipFilter, belief=BELIEF)
NO_SOLVERS = but(NOT_OURS, one="piqp", unknown=["piqp", "nobody"], numbers=[1])
NO_PLACES = but(NO_POINTS, three=np.zeros((3, 2)))
BOXED = but(NO_NUMBERS, "masked without a mask", number=1.0, spatial=[1.0, 2.0, 3.0], above=[9.0, 9.0])
ARENA = but(
    NO_POINTS, below=[[1, 0], [0, 1]], nan=[[np.nan, 0], [1, 1]], nowhere=[[np.inf, 0], [np.inf, 1]], texts=[["0"] * 2] * 2
)
ANGLES = but(
    NO_NUMBERS,
    "NaN",
    "infinite",
    "beyond any length",
    "long double beyond any float",
    three=[0.0, 0.1, 0.2],
    table=np.zeros((2, 2)),
)
TURN = but(NO_NUMBERS, three=[0.0, 0.1, 0.2], table=np.zeros((2, 2)))
COVARIANCE = but(NO_NUMBERS, flat=np.ones(4), lopsided=[[[1, 0.5], [0.4, 1]]] * 2, indefinite=[[[1, 2], [2, 1]]] * 2)
INDEX = but(
    NO_WHOLE_NUMBER, "masked without a mask", "numpy's True", "True", "pair", "below 0", beyond=2, before=-3, slices=slice("a")
)
PART = but(NO_WHOLE_NUMBERS, "truths", "True", "below 0", "below 0 in a column", beyond=2, before=-3, table=[[0]])

# What is called with a wrong value of one argument, and what is wrong there.
CALLS = {
    "Team: robots": (Team, but(COUNT, none=0, many=10**7)),
    "Team: landmarks": (lambda x: Team(2, x), NO_POINTS),
    "Team: speed_limit": (lambda x: Team(3, speed_limit=x), LIMIT),
    "Team: turn_rate_limit": (lambda x: Team(3, turn_rate_limit=x), LIMIT),
    "Team: arena": (lambda x: Team(2, arena=x), ARENA),
    "Team.name": (TEAM.name, but(COUNT, beyond=4)),
    "Team.check": (TEAM.check, NOT_OURS),
    "Compass: time": (lambda x: Compass(x, 0, 0, 0.1), NO_NUMBER),
    "Compass: robot": (lambda x: Compass(0, x, 0, 0.1), NO_WHOLE_NUMBERS),
    "Compass: heading": (lambda x: Compass(0, 0, x, 0.1), NO_NUMBERS),
    "Compass: bound": (lambda x: Compass(0, 0, 0, x), BOUND),
    "Bearing: time": (lambda x: Bearing(x, 0, 1, 0, 0.1), NO_NUMBER),
    "Bearing: robot": (lambda x: Bearing(0, x, 7, 0, 0.1), NO_WHOLE_NUMBERS),
    "Bearing: target": (lambda x: Bearing(0, 7, x, 0, 0.1), NO_WHOLE_NUMBERS),
    "Bearing: bearing": (lambda x: Bearing(0, 0, 1, x, 0.1), NO_NUMBERS),
    "Bearing: bound": (lambda x: Bearing(0, 0, 1, 0, x), BOUND),
    "Range: time": (lambda x: Range(x, 0, 1, 1, 0.1, 0), NO_NUMBER),
    "Range: robot": (lambda x: Range(0, x, 7, 1, 0.1, 0), NO_WHOLE_NUMBERS),
    "Range: target": (lambda x: Range(0, 7, x, 1, 0.1, 0), NO_WHOLE_NUMBERS),
    "Range: range": (lambda x: Range(0, 0, 1, x, 0.1, 0), BOUND),
    "Range: bound": (lambda x: Range(0, 0, 1, 1, x, 0), BOUND),
    "Range: relative_bound": (lambda x: Range(0, 0, 1, 1, 0.1, x), BOUND),
    "Odometry: start": (lambda x: Odometry(x, 1, 0, 0, 0, 0, 0, 0, 0), NO_NUMBER),
    "Odometry: time": (lambda x: Odometry(0, x, 0, 0, 0, 0, 0, 0, 0), SPREAD),
    "Odometry: robot": (lambda x: Odometry(0, 1, x, 0, 0, 0, 0, 0, 0), but(NO_WHOLE_NUMBERS, twice=[1, 1])),
    "Odometry: distance": (lambda x: Odometry(0, 1, 0, x, 0, 0, 0, 0, 0), NO_NUMBERS),
    "Odometry: distance_bound": (lambda x: Odometry(0, 1, 0, 0, x, 0, 0, 0, 0), BOUND),
    "Odometry: turn": (lambda x: Odometry(0, 1, 0, 0, 0, x, 0, 0, 0), NO_NUMBERS),
    "Odometry: turn_bound": (lambda x: Odometry(0, 1, 0, 0, 0, 0, x, 0, 0), BOUND),
    "Odometry: direction_bound": (lambda x: Odometry(0, 1, 0, 0, 0, 0, 0, x, 0), BOUND),
    "Odometry: slip_bound": (lambda x: Odometry(0, 1, 0, 0, 0, 0, 0, 0, x), BOUND),
    "Frame: time": (Frame, NO_NUMBER),
    "Frame: odometry": (lambda x: Frame(0, x), but(NO_MOTION, "stranger")),
    "Frame: measurements": (lambda x: Frame(0, None, x), but(NO_RECORDS, "stranger", "far")),
    "Frame: truth": (lambda x: Frame(0, None, (), x), OPTION),
    "Truth: positions": (lambda x: Truth(x, [0, 0]), NO_PLACES),
    "Truth: headings": (lambda x: Truth(np.zeros((2, 2)), x), but(ANGLES, number=0.0)),
    "wrap": (wrap, but(ANGLES, "three", "table")),
    "arcs: centre": (lambda x: AngularIntervals(x, 0.1), but(TURN, "three")),
    "arcs: bound": (lambda x: AngularIntervals([0, 1], x), TURN),
    "arcs: circles": (AngularIntervals.circles, but(COUNT, many=10**12)),
    "arcs: contains": (ARCS.contains, ANGLES),
    "arcs: turned by": (ARCS.turned, TURN),
    "arcs: turned, bound": (lambda x: ARCS.turned(0, x), but(TURN, negative=-1e-9)),
    "arcs: intersection": (ARCS.intersection, but(NOT_OURS, few=ARCS[0], more=AngularIntervals.circles(3))),
    "arcs: index": (ARCS.__getitem__, PART),
    "Polygon.box: lower": (lambda x: Polygon.box(x, [1, 1]), BOXED),
    "Polygon.box: upper": (lambda x: Polygon.box([5, 5], x), but(BOXED, "above", below=[0, 9])),
    "Polygon.from_vertices": (Polygon.from_vertices, but(NO_POINTS, none=np.zeros((0, 2)), nan=[[0, np.nan]])),
    "Polygon.hull": (Polygon.hull, but(NO_POINTS, none=[], infinite=[[0, np.inf]])),
    "half-planes: normals": (lambda x: Polygon.from_half_planes(x, [1], [-1, -1], [1, 1]), but(NO_PLACES, flat=[1, 0])),
    "half-planes: offsets": (lambda x: Polygon.from_half_planes([[1, 0]], x, [-1, -1], [1, 1]), but(NO_NUMBERS, two=[1, 1])),
    "polygon: contains": (BOX.contains, NO_POINTS),
    "polygon: support": (BOX.support, but(NO_POINTS, flat=[1, 0], nan=[[0, np.nan]])),
    "polygon: intersection": (BOX.intersection, NOT_OURS),
    "sets: team": (SetMembershipFilter, NO_TEAM),
    "sets: solvers": (lambda x: SetMembershipFilter(TEAM, solvers=x), NO_SOLVERS),
    "sets: stop": (lambda x: SetMembershipFilter(TEAM, stop=x), but(NOT_OURS, kind=Stop)),
    "sets: rows_per_robot": (lambda x: SetMembershipFilter(TEAM, rows_per_robot=x), but(COUNT, few=3)),
    "sets: rows_per_pair": (lambda x: SetMembershipFilter(TEAM, rows_per_pair=x), but(COUNT, few=3)),
    "sets: pairs": (lambda x: SetMembershipFilter(TEAM, pairs=x), COUNT),
    "sets: corners": (lambda x: SetMembershipFilter(TEAM, corners=x), NOT_OURS),
    "sets: tangent_spacing": (lambda x: SetMembershipFilter(TEAM, tangent_spacing=x), ABOVE_0),
    "sets: scope": (lambda x: SetMembershipFilter(TEAM, scope=x), but(NOT_OURS, "text", kind=Window, other="everybody")),
    "sets: policy": (lambda x: SetMembershipFilter(TEAM, policy=x), but(NOT_OURS, several=["raise"])),
    "sets: budget": (lambda x: SetMembershipFilter(TEAM, budget=x), but(OPTION, kind=Budget)),
    "sets: threads": (lambda x: SetMembershipFilter(TEAM, threads=x), but(COUNT, "None", none=0)),
    "sets: on_phase": (lambda x: SetMembershipFilter(TEAM, on_phase=x), NOT_OURS),
    "light: team": (SetMembershipFilter.light, NO_TEAM),
    "robust: team": (RobustFilter, NO_TEAM),
    "robust: alignment": (lambda x: RobustFilter(TEAM, alignment=x), but(NOT_OURS, kind=Alignment)),
    "Kalman: team": (ExtendedKalmanFilter, NO_TEAM),
    "Kalman: noise": (lambda x: ExtendedKalmanFilter(TEAM, x), but(NOT_OURS, kind=NoiseModel)),
    "Kalman: gate": (lambda x: ExtendedKalmanFilter(TEAM, gate=x), but(ABOVE_0, "None", one=1.0)),
    "Gaussian: mean": (lambda x: GaussianBelief(0, x, np.eye(6)), but(NO_POINTS, "spatial", short=np.zeros((1, 3)))),
    "Gaussian: covariance": (lambda x: GaussianBelief(0, np.zeros((2, 3)), x), but(NO_POINTS, short=np.eye(5))),
    "Gaussian: relative": (lambda x: GAUSSIAN.relative(0, x), but(COUNT, beyond=2)),
    "NoiseModel.same": (NoiseModel.same, but(ABOVE_0, many=1e7)),
    "Stop: performance_ratio": (Stop, but(SPREAD, above=1.1)),
    "Stop: area_gap": (lambda x: Stop(area_gap=x), SPREAD),
    "Stop: searches": (lambda x: Stop(searches=x), but(COUNT, few=3)),
    "Budget: seconds": (lambda x: Budget(x, time.perf_counter), SPREAD),
    "Budget: clock": (lambda x: Budget(1.0, x), NOT_OURS),
    "a clock's time": (lambda x: Budget(1.0, lambda: x).begin(), NO_NUMBER),
    "Window: hops": (Window, but(COUNT, none=0)),
    "Window: robots": (lambda x: Window(1, x), but(COUNT, one=1)),
    "Alignment: share": (Alignment, but(ABOVE_0, above=1.1)),
    "lag: inner": (lambda x: FixedLag(x, len), NO_FILTER),
    "lag: motion": (lambda x: FixedLag(SETS, x), OPTION),
    "lag: lag": (lambda x: FixedLag(SETS, len, x), SPREAD),
    "lag: gap": (lambda x: FixedLag(SETS, len, gap=x), SPREAD),
    "lag: restart": (lambda x: FixedLag(SETS, len, restart=x), OPTION),
    "lag: begin": (LAG.begin, NOT_OURS),
    "lag: merge into": (lambda x: LAG.merge(x, [COMPASS]), but(NOT_OURS, belief=BELIEF)),
    "lag: merge": (lambda x: LAG.merge(LAGGED, x), NO_RECORDS),
    "lag: a motion": (lambda x: FixedLag(SETS, lambda *times: x).merge(LAGGED, [Compass(1, 0, 0, 1)]), NO_MOTION),
    "follow: filter": (lambda x: follow(x, BELIEF, []), NO_FILTER),
    "follow: belief": (lambda x: follow(SETS, x, []), NOT_OURS),
    "follow: frames": (lambda x: list(follow(SETS, BELIEF, x)), NO_FRAMES),
    "follow: clock": (lambda x: follow(SETS, BELIEF, [], x), OPTION),
    "watch: belief": (lambda x: watch(x, np.zeros((2, 2))), but(NO_BELIEF, kalman=GAUSSIAN)),
    "watch: positions": (lambda x: watch(BELIEF, x), but(NO_PLACES, infinite=[[0, 0], [0, np.inf]])),
    "watch: covariances": (lambda x: watch(BELIEF, np.zeros((2, 2)), x), but(COVARIANCE, "None")),
    "watch: probability": (lambda x: watch(BELIEF, np.zeros((2, 2)), None, x), but(SPREAD, one=1.0)),
    "watch: moved": (lambda x: watch(BELIEF, np.zeros((2, 2)), moved=x), but(SPREAD, "pair")),
    "regions: index": (BELIEF.regions.__getitem__, INDEX),
    "regions: contains": (BELIEF.regions.contains, NO_PLACES),
    "causes: robot": (lambda x: BELIEF.causes(x, 0), but(COUNT, beyond=2)),
    "causes: edge": (lambda x: BELIEF.causes(0, x), but(COUNT, beyond=99)),
}
for own, belief in zip(FILTERS, BELIEFS, strict=True):
    name = type(own).__name__
    CALLS |= {
        f"{name}.start: time": (lambda x, own=own: own.start(x, [BOX, BOX]), NO_NUMBER),
        f"{name}.start: positions": (lambda x, own=own: own.start(0, x), NO_POLYGONS),
        f"{name}.start: headings": (lambda x, own=own: own.start(0, [BOX, BOX], x), NO_ARCS),
        f"{name}.predict: belief": (lambda x, own=own: own.predict(x, 1.0), NO_BELIEF),
        f"{name}.predict: time": (lambda x, own=own, belief=belief: own.predict(belief, x), but(NO_NUMBER, far=1e100 * 3)),
        f"{name}.predict: odometry": (lambda x, own=own, belief=belief: own.predict(belief, 1.0, x), NO_MOTION),
        f"{name}.update: belief": (lambda x, own=own: own.update(x, [COMPASS]), NO_BELIEF),
        f"{name}.update: measurements": (lambda x, own=own, belief=belief: own.update(belief, x), NO_RECORDS),
    }


@pytest.mark.filterwarnings("ignore")  # numpy warns where it takes what it should not: then nobody else would tell
@pytest.mark.parametrize("name", CALLS)
def test_what_is_wrong_is_refused_with_what_was_expected_and_what_came(name):
    call, wrong = CALLS[name]
    before, taken = snapshot(BELIEFS), []
    for key, make in wrong.items():
        try:
            call(make())
        except InvalidInput as error:
            text = str(error)
            assert text.startswith("expected ") and "; came " in text, (key, text)
            assert len(text) <= MOST and "\n" not in text, (key, text)
        else:
            taken.append(key)
    assert not taken
    assert snapshot(BELIEFS) == before
