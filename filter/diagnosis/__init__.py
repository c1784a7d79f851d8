"""Diagnosis: what is known although something is wrong: lies that are tolerated; and after a conflict, until it is found out.

Read the modules in this order: told, tolerance, cover, voting, tolerant, suspects, evidence, hypotheses, replays,
starting_over, judging, quiet, set_membership_filter, robust_filter.
"""
