"""What the package offers."""

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """One contact algorithm."""
    return [Part("contact", "dual-mortar", "dual_mortar.contact:DualMortar", "biorthogonal multipliers")]
