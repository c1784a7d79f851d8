"""Tests are not timed: what is compiled takes seconds when it is called for the first time."""

from hypothesis import settings

settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
