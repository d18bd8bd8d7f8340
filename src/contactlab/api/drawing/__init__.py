"""Colours and units shared by everything that draws."""
