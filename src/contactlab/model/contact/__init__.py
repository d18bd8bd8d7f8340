"""Contact: surfaces, pairs, gap constraints, and their linearisation."""
