"""Implicit steps: Newton's iteration with contact, its linear systems, and what a step books."""
