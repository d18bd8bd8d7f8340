"""Friction laws for contactlab."""
