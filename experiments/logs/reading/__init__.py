"""The lines of a log, read in two ways: fast, by typed decoding, and strictly, a field at a time, to say what is wrong."""
