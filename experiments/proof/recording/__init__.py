"""What shows the regions of a run: summary, trajectories, and a recording of Rerun, read without it, with all tables."""
