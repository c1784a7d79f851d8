"""The team's polytope projected onto one robot, or onto a pair: from inside and from outside.

Read the modules in this order: stop, claims, proved, search, fallback, simplex, shadow, window, inside, sheet, walk, team.
"""
