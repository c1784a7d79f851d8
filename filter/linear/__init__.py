"""Half-planes on robots and pairs, the polytope they make, and bounds on it that are proved, whoever solved.

Read the modules in this order: constraints, sources, program, polytope, solvers, certify.
"""
