"""Contact at points of the slave, nodes or Gauss points, for contactlab."""
