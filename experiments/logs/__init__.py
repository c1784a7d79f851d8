"""Logs, trajectories and certificates: what a run was given, and what it says, as files."""
