"""Templates of kernels, in which formulas of parts are put."""
