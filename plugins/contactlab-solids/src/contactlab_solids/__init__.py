"""Plane-strain material laws for contactlab."""
