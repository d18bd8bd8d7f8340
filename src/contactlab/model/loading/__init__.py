"""Loading: supports, loads, effects, rigid surfaces, and their variation in time."""
