"""What is in a recording of Rerun, read without it: the container, the tables in it, and the regions that they show."""
