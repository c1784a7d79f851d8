"""What a filter was given, as its log says: read strictly, made frames of, in exact numbers. Standard library only."""
