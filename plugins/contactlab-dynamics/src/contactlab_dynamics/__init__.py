"""Explicit dynamics for contactlab."""
