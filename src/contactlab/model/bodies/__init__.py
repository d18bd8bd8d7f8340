"""Bodies: blocks of cells, stresses and internal forces, stable steps, stiffness."""
