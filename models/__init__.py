"""MJCF models and their paths."""

from pathlib import Path

FOLDER = Path(__file__).parent
ARENA = FOLDER / "arena.xml"
DIFFDRIVE = FOLDER / "diffdrive.xml"
