"""Records as they come: where they come from, what is read of them, and what is answered.

Read in this order: lines, intake, sources, reading, spread, tally, now, truths, answers,
words, answering.
"""
