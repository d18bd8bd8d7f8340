"""What a run gives back: frames, histories, summaries, and the files that keep them."""
