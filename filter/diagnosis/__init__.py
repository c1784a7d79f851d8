"""Diagnosis: what is known after a conflict, whichever one thing is wrong, until it is found.

Read the modules in this order: told, suspects, evidence, cover, hypotheses, replays, starting_over, judging, quiet,
set_membership_filter.
"""
