"""The parts of `experiments.ekf_comparison`."""
