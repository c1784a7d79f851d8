"""The parts of the paper's own experiments, `experiments.static_localization` and `experiments.search_strategy`."""
