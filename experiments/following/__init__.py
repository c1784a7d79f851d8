"""A filter follows a scenario, step by step, and is measured."""
