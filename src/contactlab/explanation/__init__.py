"""Effects and cost of a scene, before it is run."""
