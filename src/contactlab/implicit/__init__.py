"""Implicit steps: Newton's iteration with contact, its linear systems, and the energy balance of a step."""
