"""Putting cases to parts: running their jobs, keeping records, judging what came out."""
