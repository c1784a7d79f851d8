"""The parts of `experiments.scaling`."""
