"""Barrier contact by the IPC Toolkit, for contactlab."""
