"""One script a question; `python -m experiments.NAME --help`."""
