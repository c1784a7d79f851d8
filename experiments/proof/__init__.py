"""The parts of `experiments.prove`: exact arithmetic, with nothing but Python's standard library."""
