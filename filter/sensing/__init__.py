"""From records to constraints: what sensors say of positions and headings, and how far robots can have moved.

Read the modules in this order: motion, since, readings, ties, headings, arms, rows, looks.
"""
