"""The matrix of cases against algorithms: its cells, the archive of what was run, and the files that show it."""
