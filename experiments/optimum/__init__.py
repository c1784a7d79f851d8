"""The parts of `experiments.tightness`."""
