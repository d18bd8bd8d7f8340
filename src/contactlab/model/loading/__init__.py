"""Loading: supports, loads, effects, rigid surfaces, and how they vary in time."""
