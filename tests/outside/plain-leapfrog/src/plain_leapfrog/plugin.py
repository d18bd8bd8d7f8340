"""What the package offers."""

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """One integrator."""
    target = "plain_leapfrog.integrator:PlainLeapfrog"
    return [Part("integrator", "plain-leapfrog", target, "central differences")]
