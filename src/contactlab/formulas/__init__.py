"""Templates of kernels, which formulas of plugins complete."""
