"""Implicit integrators on offer, and the enforcements that work with them."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl


@hookimpl
def contactlab_parts() -> list[Part]:
    """Quasi-statics, dynamics in large steps, and exact multipliers by active sets."""
    return [
        Part(
            "integrator",
            "newton",
            "contactlab_statics.newton:Newton",
            "quasi-static load steps by Newton's method",
            "Wriggers 2006, ch. 10; Alart & Curnier 1991",
        ),
        Part(
            "integrator",
            "implicit-dynamics",
            "contactlab_statics.implicit_dynamics:ImplicitDynamics",
            "midpoint rule in large steps, contact without ringing",
            "Simo & Tarnow 1992; Laursen & Love 2002",
        ),
        Part(
            "enforcement",
            "active-set",
            "contactlab_statics.active_set:ActiveSet",
            "exact multipliers of the saddle point problem",
            "Hintermueller, Ito & Kunisch 2002; Alart & Curnier 1991",
        ),
        Part(
            "enforcement",
            "penalty",
            "contactlab_statics.penalty:Penalty",
            "springs between the surfaces, stiffness derived from the bodies'",
            "Wriggers 2006, ch. 10.3",
        ),
        Part(
            "enforcement",
            "augmented-lagrangian",
            "contactlab_statics.penalty:AugmentedLagrangian",
            "springs, whose forces are taken over until gaps vanish",
            "Simo & Laursen 1992",
        ),
    ]
