"""Compiled loops of contact: search, coupling, rows, pairs, derivatives."""
