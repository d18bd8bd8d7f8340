"""Contact between surfaces, by positions of their nodes alone: search, coupling, rows and systems of all pairs."""
