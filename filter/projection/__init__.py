"""The team's polytope projected onto one robot, or onto a pair: from inside and from outside.

Read the modules in this order: budget, polygons_of, search, simplex, shadow, exact, projector, window, walk, claims, team.
"""
