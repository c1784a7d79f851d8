"""Evidence on cameras, beside the sets: an estimate of how far each is turned, and how late it is. Nothing of it is proved.

Read the modules in this order: alignment, sightings, offsets.
"""
