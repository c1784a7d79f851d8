"""A minute of two robots in every form that own data come in. From the drive to what is said of it, then to files."""
