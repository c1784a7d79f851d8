"""Proves a whole run again, in exact rational arithmetic, with nothing but Python's standard library.

    python -m experiments.prove FOLDER [--workers N]

reads what `python -m experiments.moving_team --certificates`, or `experiments.follow` with it, left in FOLDER (see
docs/soundness.md): the log, and for each of its frames the headings with what made them narrower, a closed polygon of each
robot with the proof of every edge, and the regions as the recording, the trajectories and the summary show them. Each line is
proved in itself (`experiments.proof.line`), and each step tied to its measurements and to the steps before
(`experiments.proof.chain`). What the summary says is tolerated is the condition: with votes sightings count as these alone, and
else there is a chain for each case of who lies. What is on trust is said first. Of `experiments.mrclam`, whose summary has
figures of its own, all this is in FOLDER/certified, and only that is proved. With `--workers N` so many processes share the
proof.

Exit code: 0 if everything is proved, 1 if something is not, or a file is damaged or is not there, 2 if there are no
certificates at all, 3 if the verdict cannot be written.
"""

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from experiments.proof.alternatives.cover import Cover
from experiments.proof.alternatives.doubts import Doubts
from experiments.proof.alternatives.tolerance import VOTES, Tolerance
from experiments.proof.alternatives.tolerated import Tolerated
from experiments.proof.edges import WORLD
from experiments.proof.given.frame import Frame
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken, Feed, Record, located, parsed, shown
from experiments.proof.recording.recorded import check_recording
from experiments.proof.recording.told import Told
from experiments.proof.share import Share, shared
from experiments.proof.shown import Region, checked_region, region_of

CERTIFIED = "certified"  # a folder in that of a run, for all that is to be proved
LINES, HEADINGS, REGIONS = "certificates.jsonl.gz", "headings.jsonl.gz", "regions.jsonl.gz"
ALTERNATIVES = "alternatives.jsonl.gz"
SUMMARY, TRAJECTORY = "summary.json", "trajectories/{}_filter.tum"
RECORDINGS = ("moving_team.rrd", "follow.rrd")  # the first, where a summary does not say which there is, or that there is none
BAR = 40  # characters
TRUST = "on trust: "
BESIDE = f"{TRUST}the folder's own figures, beside {CERTIFIED}/"
OTHER_ENTITIES = f"{TRUST}entities of the recording that are of no region"


def prove(folder: Path, show: Callable[[str], object], share: Share | None = None) -> Counter[str]:
    """Prove a folder, or a share of it, and take the rest as it is; return how much of what is proved, or is on trust.

    Raises:
        Broken: Something is not proved.
        OSError: There is no such file.
    """
    log, share = Log(folder), share or Share()
    _look_for_files(folder, [name for robot, name in enumerate(log.names) if log.is_there(robot)])
    checked, told, proved = _checked(folder, log, share), Told(log), list[list[Region | None]]()
    progress = _Progress(show if share.number == 0 else lambda _: None, folder / LINES)
    headings, lines, regions = Feed(folder / HEADINGS), Feed(folder / LINES, progress), Feed(folder / REGIONS)
    others = Feed(folder / ALTERNATIVES)
    for frame in log.frames:
        cover = checked.check(headings.at(frame.time), lines.at(frame.time), others.at(frame.time, least=0))
        proved.append(regions_of(frame, regions.at(frame.time), cover, is_proved=share.has_next()))
        told.add(frame, proved[-1], cover, checked.waiting)
    for feed in (headings, lines, regions, others):
        feed.end()
    counts = Counter(checked.links)
    if share.has_next():
        counts += checked.on_trust() + _shown(folder, told, log, proved)
        counts[f"frames, up to t = {log.frames[-1].time} s"] = len(log.frames)
    return counts


def _look_for_files(folder: Path, robots: Sequence[str]) -> None:
    """Raise if a file is not there, or is of no robot: to be said before the proof, which takes a while."""
    trajectories = [folder / TRAJECTORY.format(robot) for robot in robots]
    needed = [folder / name for name in (HEADINGS, LINES, REGIONS, ALTERNATIVES, SUMMARY)]
    for path in (*needed, *_recordings(folder), *trajectories):
        path.stat()
    for path in sorted(set(folder.glob(TRAJECTORY.format("*"))) - set(trajectories)):
        raise Broken(f"{path.name}: a trajectory of a robot that there is not")


def _recordings(folder: Path) -> list[Path]:
    """Return the recording that there has to be, if any; whatever recordings there are will be checked."""
    with located(SUMMARY):
        name = parsed((folder / SUMMARY).read_bytes()).get("recording", RECORDINGS[0])
        if name not in (*RECORDINGS, None):
            raise Broken(f"a recording among {', '.join(RECORDINGS)} was expected, not {shown(name)}")
    return [] if name is None else [folder / name]


def _checked(folder: Path, log: Log, share: Share) -> Doubts | Tolerated:
    """Return what checks a run's steps, under the condition that its summary names.

    Raises:
        Broken: Under that nothing can be proved.
    """
    with located(SUMMARY):
        told = parsed((folder / SUMMARY).read_bytes()).get("tolerated")
        if not told or VOTES.fullmatch(told):
            return Doubts(log, share, is_voted=bool(told))
        return Tolerated(log, Tolerance.of(told), share)


def _shown(folder: Path, told: Told, log: Log, proved: Sequence[Sequence[Region | None]]) -> Counter[str]:
    """Check what else shows regions, all of which are proved; return how much of what there is."""
    counts = told.check_summary(folder / SUMMARY)
    for robot, name in filter(lambda each: log.is_there(each[0]), enumerate(log.names)):
        counts["poses of the trajectories"] += told.check_trajectory(robot, folder / TRAJECTORY.format(name))
    for path in sorted(folder.glob("*.rrd")):
        counts["regions of the recording"], counts[OTHER_ENTITIES] = check_recording(path, log.names, log.frames, proved)
    counts["regions, closed and as they are shown"] = sum(region is not None for regions in proved for region in regions)
    counts[f"{TRUST}the measurements' own bounds"] = told.numbers()["measurements"]
    return counts


def regions_of(frame: Frame, found: list[tuple[str, Record]], cover: Cover, *, is_proved: bool = True) -> list[Region | None]:
    """Return the regions of a frame, each of them proved, or taken as it is; None of robots that are away."""
    (place, record), *more = found
    with located(f"{place} (t = {frame.time} s)"):
        if more or len(record["regions"]) != len(cover.headings):
            raise Broken(f"one record of {len(cover.headings)} regions was expected")
    regions = list[Region | None]()
    for robot, region in enumerate(record["regions"]):
        with located(f"{place} (t = {frame.time} s, robot {robot})"):
            is_there = region is not None
            if is_there == (robot in frame.away):
                raise Broken(
                    "a region of a robot that is away" if is_there else "there is no region, though the robot is there"
                )
            edges = cover.shown.get((WORLD, robot), {})
            regions.append((checked_region(region, edges) if is_proved else region_of(region)) if is_there else None)
    return regions


class _Progress:
    """Shows how much of a file has been read."""

    def __init__(self, show: Callable[[str], object], path: Path) -> None:
        self._show, self._size, self._done = show, max(path.stat().st_size, 1), -1

    def __call__(self, read: int) -> None:
        done = BAR * read // self._size
        if done != self._done:
            self._done = done
            self._show(f"\r[{'#' * done}{'.' * (BAR - done)}]")


def judged(folder: Path, workers: int = 1) -> tuple[int, str]:
    """Return the exit code and the verdict on a folder, the same whatever number of processes shares it.

    Raises:
        OSError: There are no certificates, or a file cannot be read.
    """
    own = not (folder / LINES).exists() and (folder / CERTIFIED).is_dir()
    folder = folder / CERTIFIED if own else folder
    (folder / LINES).stat()
    try:
        counts = shared(partial(prove, folder, _show), workers) + Counter({BESIDE: int(own)})
    except (Broken, FileNotFoundError) as error:
        _show("\n")
        said = str(error) if isinstance(error, Broken) else f"{os.path.relpath(error.filename, folder)} is not there"
        return 1, f"not proved: {said.encode('unicode_escape').decode()}"  # a file may say what a terminal obeys
    _show("\n")
    by_trust = sorted((+counts).items(), key=lambda one: (not one[0].startswith(TRUST), one[0]))
    return 0, "\n".join(
        [*(f"{count:8d} {name}" for name, count in by_trust), f"{counts['certificates']} certificates proved, 0 failed"]
    )


def _show(text: str) -> None:
    with suppress(OSError):  # nobody looks
        sys.stderr.write(text)
        sys.stderr.flush()


def main(arguments: Sequence[str] | None = None) -> int:
    """Prove the run in the folder that the command line names; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m experiments.prove", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="the folder of a run with --certificates")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes that share the proof (default: 1)")
    told = parser.parse_args(arguments)
    if told.workers < 1:
        parser.error("--workers: 1 or more are needed")
    try:
        code, verdict = judged(told.folder, told.workers)
        sys.stdout.write(verdict + "\n")
        sys.stdout.flush()
    except OSError as error:
        if error.filename:  # it is a file that is read
            sys.stderr.write(f"error: {error.filename}: {error.strerror}\n")
            return 2
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python fails at its end on what waits there
        with suppress(OSError):
            sys.stderr.write(f"error: the verdict cannot be written: {error.strerror}\n")
        return 3
    return code


if __name__ == "__main__":
    sys.exit(main())
