"""Error against computing time: cases and methods on several mesh levels, and evaluations of the points."""
