"""Arcs of the circle and convex polygons in the plane.

Read the modules in this order: angles, north, convex, simplify, polygon, hyperbola, many, around, sector.
"""
