"""Sets of poses of one robot, position and heading together: cells that are split, cut by what was measured, and dropped.

Read the modules in this order: cone, cell, split, branch, cells.
"""
