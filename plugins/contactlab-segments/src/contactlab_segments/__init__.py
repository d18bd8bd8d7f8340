"""Contact at points of the slave, nodes or Gauss points, and contact without a slave, for contactlab."""
