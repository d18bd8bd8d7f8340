"""Newton's method for contactlab."""
