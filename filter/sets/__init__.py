"""The set-membership filter: predict, then headings, merge, prune, project.

Read the modules in this order: worth, merged, regions, suspect, proof, passes, belief, predict, refine, conflict,
set_membership.
"""
