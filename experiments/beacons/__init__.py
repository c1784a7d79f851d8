"""Parts of `experiments.range_only`: exact judges, scenes, what filters make of them, figures and a recording."""
