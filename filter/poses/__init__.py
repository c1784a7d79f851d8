"""Sets of poses of one robot, position and heading together: slices that are taken along, split into cells, cut, and dropped.

Read the modules in this order: cone, cell, slices, split, branch, turns, cells, votes.
"""
