"""The set-membership filter: predict, then headings, merge, prune, project.

Read the modules in this order: regions, belief, headings, boxes, corners, refine, pairs, rejection, set_membership.
"""
