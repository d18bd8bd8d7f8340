"""Material laws on offer."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer elastic and elastoplastic laws in plane strain."""
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
        Part(
            "material",
            "hypoelastic",
            "contactlab_solids.hypoelastic:Hypoelastic",
            "Hooke's law in rate form, Cauchy stress with the Jaumann rate",
            "Hughes & Winget 1980",
        ),
        Part(
            "material",
            "linear-hardening",
            "contactlab_solids.linear_hardening:LinearHardening",
            "J2 plasticity, sigma_y = yield_stress + hardening ep, any strain",
            "Simo 1992",
        ),
        Part(
            "material",
            "power-law",
            "contactlab_solids.power_law:PowerLaw",
            "J2 plasticity, sigma_y = K (e0 + ep)^n, any strain",
            "Swift 1952; Simo 1992",
        ),
    ]
