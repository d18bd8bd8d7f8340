"""Effects on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Forces on nodes that come neither from stresses nor from contact, and functions by which forces vary."""
    return [
        Part("effect", "attraction", "contactlab_effects.attraction:Attraction", "a force between two bodies"),
        Part("effect", "gravity", "contactlab_effects.gravity:Gravity", "weight of all bodies or of some"),
        Part("effect", "spring", "contactlab_effects.spring:Spring", "springs from nodes to the ground"),
        Part(
            "effect", "vibration-damping", "contactlab_effects.damping:VibrationDamping",
            "damping of all motion but the rigid one of each body",
        ),
        Part("function", "half-ellipse", "contactlab_effects.functions:HalfEllipse", "a half ellipse", "Hertz 1882"),
        Part("function", "polynomial", "contactlab_effects.functions:Polynomial", "a polynomial"),
        Part("function", "sine", "contactlab_effects.functions:Sine", "a sine"),
    ]  # fmt: skip
