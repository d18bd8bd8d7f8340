"""What the package offers."""

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """One enforcement."""
    return [Part("enforcement", "soft", "soft_contact.enforcement:Soft", "smooth springs that stiffen as they close")]
