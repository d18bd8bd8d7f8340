"""Effects that a scene does not declare but needs, named with the number that shows it.

Each file holds one kind of effect. What it needs to know is looked at when the model is built and at
stored frames, never in a step. docs/effects.md lists all of them with their limits.
"""
