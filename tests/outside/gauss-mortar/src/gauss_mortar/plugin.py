"""What the package offers."""

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """One contact algorithm."""
    return [Part("contact", "gauss-mortar", "gauss_mortar.contact:GaussMortar", "linear multipliers at Gauss points")]
