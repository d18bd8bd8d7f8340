"""Gravity, springs, dampers, and functions by which loads vary, for contactlab."""
