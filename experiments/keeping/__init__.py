"""A filter goes through a run, and what shall be kept of it is written as it goes on.

Read in this order: running, files, regions, against, watched, recorded.
"""
