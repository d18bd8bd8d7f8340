"""What accuracy costs in time: cases against contenders at several mesh levels, and what follows from the points."""
