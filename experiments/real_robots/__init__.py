"""A run of the UTIAS data set: its records, its bounds, its faults."""
