"""The robust filter: headings without a compass, bounds that break, sensors that lie.

Read the modules in this order: slices, sightings, hypotheses, cuts, votes, trust, cameras, camera_filter, belief, leaving,
merging, robust_filter.
"""
