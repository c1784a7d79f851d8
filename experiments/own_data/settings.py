"""The settings of a conversion, a TOML file: what is known of the team, and where its streams are. See docs/own-data.md."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from experiments.own_data.facts import Facts, read_facts
from experiments.own_data.kinds import STREAM_KINDS
from experiments.own_data.stream import Clock, Stream, read_stream
from experiments.own_data.table import Table
from experiments.recorded.words import nearest
from filter import InvalidInput

LATENESS = 10.0  # [s]
DISTRIBUTIONS = ("dashing", "eloquent", "foxy", "galactic", "humble", "iron", "jazzy", "kilted")
A_STREAM = "a table, or a list of tables"


@dataclass(frozen=True, eq=False)
class Settings:
    """All that the settings say.

    Attributes:
        facts: Of the team.
        streams: In the file's order, robot by robot.
        lateness: So much later than the newest one a stamp may come [s].
        types: Which ROS 2 a bag without definitions was recorded with, or "".
        definitions: Further definitions of messages, package/msg/Name.msg.
    """

    facts: Facts
    streams: tuple[Stream, ...]
    lateness: float
    types: str
    definitions: tuple[Path, ...]


def read_settings(path: Path) -> Settings:
    """Return the settings.

    Raises:
        InvalidInput: The file cannot be read, a key is unknown or missing, or what it holds is not as it should be.
    """
    try:
        values = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InvalidInput("settings, a readable TOML file", f"{path}: {error}") from None
    whole = Table(f"{path.name}:", values)
    team, files = whole.table("team", "what is known of all"), whole.table_or_empty("input", "a table")
    tables, every = whole.table("robots", "tables [robots.NAME]"), whole.table_or_empty("every_robot", "a table")
    whole.end()
    robots = {name: tables.table(name, "a table") for name in tables.names()}
    if not robots:
        raise InvalidInput(f"{tables.place}: at least one table [robots.NAME]", "none")
    settings = _settings(read_facts(team, robots), _streams(robots, every, files), files, path.parent)
    for table in (team, files, every, *robots.values()):
        table.end()
    settings.facts.check(f"{path.name}: [team]:")
    for stream in settings.streams:
        _check_sensors(stream, settings.facts)
    return settings


def _settings(facts: Facts, streams: tuple[Stream, ...], files: Table, folder: Path) -> Settings:
    definitions = tuple(folder / name for name in files.list_of_texts("definitions", "a list of files"))
    lateness = files.number_or("lateness", "a number [s]", LATENESS, least=0.0)
    return Settings(facts, streams, lateness, files.word("types", DISTRIBUTIONS, ""), definitions)


def _check_sensors(stream: Stream, facts: Facts) -> None:
    known = list(facts.sensors)
    for key, name in stream.sensors.items():
        if name not in known:
            near = nearest(name, known) if known else "there is none"
            raise InvalidInput(f"{stream.place}: {key}: a name in [team.sensors]: {near}", f'"{name}"')


def _streams(robots: Mapping[str, Table], every: Table, files: Table) -> tuple[Stream, ...]:
    """Return all streams; a robot's own table of a kind stands for that of every robot, and false for none."""
    clock, found = Clock.read(files, Clock("", "", 0.0)), list[Stream]()
    common = {kind: every.tables(kind, A_STREAM) for kind in STREAM_KINDS}
    for robot, table in robots.items():
        for kind in STREAM_KINDS:
            if not table.has(kind):
                tables = [each.copy() for each in common[kind]]
            else:
                tables = [] if table.is_false(kind) else table.tables(kind, A_STREAM)
            found += [read_stream(kind, robot, each, clock) for each in tables]
    if not found:
        raise InvalidInput(f"{every.place}: at least one stream of a robot: {', '.join(STREAM_KINDS)}", "none")
    return tuple(found)
