"""Contact: surfaces, pairs, gap conditions, and their linearisation."""
