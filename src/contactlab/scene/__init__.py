"""Scenes: TOML tables, their keys and checks, and changes to them."""
