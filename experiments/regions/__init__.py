"""A run's regions as files that other tools read: JSON lines, Parquet, MCAP. See docs/regions.md.

Read in this order: rows, files, as_jsonl, as_parquet, stamps, rounded, ros, scene, as_mcap, writers.
"""

from experiments.regions.rows import Estimate, Row, rows_of
from experiments.regions.writers import FORMATS, Format, Writer, check_packages, regions_writer

__all__ = ["FORMATS", "Estimate", "Format", "Row", "Writer", "check_packages", "regions_writer", "rows_of"]
