"""Compiled loops over cells, edges and rows. Nothing here knows a scene."""
