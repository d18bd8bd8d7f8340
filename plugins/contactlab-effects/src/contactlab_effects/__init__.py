"""Gravity, springs and dampers for contactlab."""
