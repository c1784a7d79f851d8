"""Logs, trajectories and certificates: what a run was given, and what it says, as files. No simulator, no pictures."""

from experiments.logs.certificates import Certificates
from experiments.logs.log import InvalidLog, LogReader, LogWriter
from experiments.logs.records import (
    FrameEnd,
    Header,
    InitialSet,
    Joined,
    Record,
    TruthAt,
    first_belief,
    initial_headings,
)
from experiments.logs.text import TextFile
from experiments.logs.tum import Trajectory, find_trajectories, read_trajectory, tum_line

__all__ = [
    "Certificates",
    "FrameEnd",
    "Header",
    "InitialSet",
    "InvalidLog",
    "Joined",
    "LogReader",
    "LogWriter",
    "Record",
    "TextFile",
    "Trajectory",
    "TruthAt",
    "find_trajectories",
    "first_belief",
    "initial_headings",
    "read_trajectory",
    "tum_line",
]
