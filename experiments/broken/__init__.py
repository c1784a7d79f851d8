"""The parts of `experiments.faults`: episodes in which one bound is broken, and an independent judge of what can be known."""
