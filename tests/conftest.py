"""What holds for all tests."""

from hypothesis import settings

# The same examples in every run, whatever the machine's speed (what is compiled takes seconds at its first call): a failure
# can be repeated.
settings.register_profile("corral", derandomize=True, deadline=None, database=None, max_examples=30)
settings.load_profile("corral")
