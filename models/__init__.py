"""MJCF models and their paths."""

from pathlib import Path

FOLDER = Path(__file__).parent
DIFFDRIVE = FOLDER / "diffdrive.xml"
