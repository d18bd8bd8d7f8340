"""Material laws on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Elastic laws in plane strain."""
    return [
        Part(
            "material",
            "linear-elastic",
            "contactlab_solids.linear_elastic:LinearElastic",
            "Hooke's law, small displacements",
        ),
        Part(
            "material",
            "neo-hookean",
            "contactlab_solids.neo_hookean:NeoHookean",
            "compressible neo-Hookean law, any strain",
            "Bonet & Wood 2008, 6.4.3",
        ),
    ]
