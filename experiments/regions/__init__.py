"""A run's regions as files that other tools read: JSON lines, Parquet, MCAP. See docs/regions.md.

Read in this order: rows, files, as_jsonl, as_parquet, stamps, rounded, ros, as_ros2, scene, as_mcap,
writers.
"""

from experiments.regions.rows import Estimate, Row, rows_of
from experiments.regions.writers import FILES, FORMATS, Format, Writer, check_packages, regions_writer

__all__ = ["FILES", "FORMATS", "Estimate", "Format", "Row", "Writer", "check_packages", "regions_writer", "rows_of"]
