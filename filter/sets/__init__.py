"""The set-membership filter: predict, then headings, merge, prune, project.

Read the modules in this order: worth, merged, passes, regions, suspect, proof, belief, predict, refine, conflict,
set_membership.
"""
