"""Results of a run: frames, histories, summaries, and the files that keep them."""
