"""Short programs to begin with, each with a little world of its own; `python -m experiments` says in which order."""
