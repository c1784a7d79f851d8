"""What was found case by case: poses of a robot that are split, cut anew and dropped, and what is taken along of them."""
