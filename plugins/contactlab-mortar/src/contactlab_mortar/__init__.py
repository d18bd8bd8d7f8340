"""Mortar contact for contactlab."""
