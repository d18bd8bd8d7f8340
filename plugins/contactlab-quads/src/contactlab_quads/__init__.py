"""Quadrilateral elements for contactlab."""
