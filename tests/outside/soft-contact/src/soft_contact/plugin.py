"""What the package offers."""

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Two enforcements."""
    return [
        Part("enforcement", "soft", "soft_contact.enforcement:Soft", "smooth springs that stiffen as they close"),
        Part("enforcement", "half-traction", "soft_contact.half_traction:HalfTraction", "half stress, half spring"),
    ]
