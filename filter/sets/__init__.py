"""The set-membership filter: predict, then headings, merge, prune, project.

Read the modules in this order: regions, belief, predict, refine, rejection, set_membership.
"""
