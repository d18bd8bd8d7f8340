"""What the package offers."""

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """The algorithm with derivatives of its own, and without."""
    return [
        Part("contact", "closest-point", "closest_point.contact:ClosestPoint", "nodes on segments, derivatives given"),
        Part("contact", "closest-point-plain", "closest_point.contact:Plain", "nodes on segments, no derivatives"),
    ]
