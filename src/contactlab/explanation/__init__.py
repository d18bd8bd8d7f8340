"""What a scene calls for and what it costs, before it is run."""
