"""Invariants that a run breaks, in words: what was seen, and what to try."""

from __future__ import annotations

from contactlab.api import RunWarning
from contactlab.results.invariants import Invariant

SIDES = "try finer cells, the other side as slave (swap), or another algorithm"
TEXTS: dict[str, tuple[str, str, str]] = {
    "not-finite": ("integrator", "an energy of the last frame is not a number", "look at loads and laws"),
    "ledger": ("integrator", "the works of all forces and the energies differ by {value} of the largest energy", ""),
    "unbalanced-reactions": (
        "integrator.tolerance", "reactions and loads are out of balance by {value} of the largest of them",
        "ask for a smaller tolerance",
    ),
    "linear-momentum": (
        "contacts.0.algorithm", "momentum is not kept: {name} is {value} of the sum of all magnitudes",
        "the contact algorithm does not push both sides alike: try another",
    ),
    "angular-momentum": (
        "contacts.0.algorithm", "angular momentum is not kept: {name} is {value}",
        "contact forces do not act along the line between the surfaces: try a mortar, or finer cells",
    ),
    "asymmetry": (
        "symmetry", "the scene is declared symmetric, and displacements differ by {value} of the largest one",
        "take shorter steps, or the declaration out",
    ),
    "contact-pull": (
        "enforcement", "contact pulls, or friction is beyond its bound, by {value} of the largest contact force",
        "take shorter steps, or another enforcement",
    ),
    "pressure-integral": (
        "algorithm", "the pressure over the slave adds up to a force that differs by {value} from the one that acts",
        SIDES,
    ),
    "penetration": ("algorithm", "one side lies {value} of a segment deep in the other", SIDES),
    "kept-overlap": (
        "swap", "pressed surfaces overlap, so that forces are too small: to close them would take {value} of the work "
        "of the stresses",
        "try the side with the shorter segments as slave (swap), finer cells of the slave, or forces = \"published\"",
    ),
    "pressure-saw": (
        "swap", "the pressure alternates from node to node, by {value} of its largest value",
        "try the other side as slave (swap), a mortar, or a master with finer cells",
    ),
    "shear-saw": (
        "swap", "the shear alternates from node to node, by {value} of its largest value",
        "try the other side as slave (swap), a mortar, or a master with finer cells",
    ),
}  # fmt: skip
"""By code: key of the scene (of the contact, where there is one), what was seen, what to try."""

LEDGER = {
    True: ("time.fraction", "take shorter steps"),
    False: (
        "integrator.steps",
        "a load that is there from the first step on does its work in one step, of which only both ends are known; "
        "give loads a ramp, or take more steps (integrator.steps)",
    ),
}
"""Key and cure of a ledger that does not close, of explicit and implicit runs."""


def breach(one: Invariant, explicit: bool) -> RunWarning:
    """The warning of an invariant that is broken."""
    key, seen, cure = TEXTS[one.code]
    if one.code == "ledger":
        key, cure = LEDGER[explicit]
    key = f"{one.where}.{key}" if one.where else key
    told = seen.format(name=one.name, value=_share(one.value))
    text = f"{one.where}{': ' if one.where else ''}{told} (allowed {_share(one.limit)}); {cure}"
    return RunWarning(one.code, one.value, one.limit, key, text)


def _share(value: float) -> str:
    return f"{value:.2g}" if not 1e-4 <= value < 10.0 else f"{value:.2%}" if value < 0.095 else f"{value:.0%}"
