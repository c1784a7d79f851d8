"""What is known in each of several cases, side by side, and what holds in all of them."""
