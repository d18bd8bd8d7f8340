"""Running a model: the step loop, step lengths, guards, recorders, restart."""
