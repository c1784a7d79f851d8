"""The set-membership filter: predict, then headings, merge, prune, project.

Read the modules in this order: regions, events, belief, predict, merge, refine, rejection, set_membership.
"""
