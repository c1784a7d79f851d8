"""The robust filter: headings without a compass, bounds that break, sensors that lie.

Read the modules in this order: slices, hypotheses, votes, trust, cameras, belief, merging, robust_filter.
"""
