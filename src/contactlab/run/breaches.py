"""Invariants that a run breaks, in words: what happened, where, the number against its limit, and what to try."""

from __future__ import annotations

from contactlab.api import RunWarning
from contactlab.model.model import Model
from contactlab.results.invariants import RESOLVED, Invariant

COARSER = 1.8  # times the segments of the slave
FINER = "refine the cells along both surfaces (level)"
TEXTS: dict[str, tuple[str, str, str]] = {
    "not-finite": ("integrator", "an energy of the last frame is not finite", "check loads and material models"),
    "ledger": ("integrator.steps", "works of all forces and energies differ by {value} of the largest energy", ""),
    "unbalanced-reactions": (
        "integrator.tolerance", "reactions and loads are out of balance by {value} of the largest of them",
        "reduce integrator.tolerance",
    ),
    "linear-momentum": (
        "contacts.0.algorithm", "linear momentum is not conserved, {name}: {value} of the sum of magnitudes",
        "use another contact algorithm: this one does not apply equal and opposite forces",
    ),
    "angular-momentum": (
        "contacts.0.algorithm", "angular momentum is not conserved, {name}: {value}",
        "refine the cells, or use a mortar algorithm: contact forces do not act along the line between the surfaces",
    ),
    "asymmetry": (
        "symmetry", "displacements of a scene with symmetry = \"x\" differ by {value} of the largest one",
        "take shorter steps, or remove symmetry if the scene has none",
    ),
    "contact-pull": (
        "enforcement", "contact pulls, or friction exceeds its bound, by {value} of the largest force of the run",
        "take shorter steps, or another enforcement",
    ),
    "pressure-integral": (
        "algorithm", "integrated contact pressure and contact force differ by {value}",
        f"{FINER}, or exchange slave and master (swap)",
    ),
    "penetration": (
        "algorithm", "penetration of one side is {value} of a segment length", f"{FINER}, or exchange slave and master "
        "(swap)",
    ),
    "kept-overlap": (
        "swap", "pressed surfaces keep an overlap: forces of given motions are too small, and bodies pressed by loads "
        "lie too deep; removing it would take {value} of the work of the stresses", "",
    ),
    "creep": (
        "algorithm", "nodes that stick creep by {value} of the motion of the surfaces in the last step: friction holds "
        "them too weakly", "reduce slip of the algorithm, or use multipliers (mortar-p1)",
    ),
    "pressure-saw": ("algorithm", "the pressure alternates from node to node by {value} of its largest value", ""),
    "shear-saw": ("algorithm", "the shear alternates from node to node by {value} of its largest value", ""),
}  # fmt: skip
"""By code: key of the scene (or of the contact), what was found, what to try; "" if that depends on the run."""


def breach(one: Invariant, model: Model) -> RunWarning:
    """The warning of an invariant that is broken."""
    key, seen, cure = TEXTS[one.code]
    if one.code == "ledger" and model.explicit:
        key = "time.fraction"
    if one.code == "unbalanced-reactions" and one.limit == RESOLVED:
        key, cure = "materials", (
            "positions are numbers of 16 digits and resolve the forces of the stiffest body no better; take a rigid "
            "surface for it, or a smaller young"
        )  # fmt: skip
    key = f"{one.where}.{key}" if one.where else key
    told = seen.format(name=one.name, value=_share(one.value))
    text = f"{one.where}{': ' if one.where else ''}{told} (limit {_share(one.limit)}); {cure or _cure(one, model)}"
    return RunWarning(one.code, one.value, one.limit, key, text)


def _cure(one: Invariant, model: Model) -> str:
    if one.code == "ledger":
        if model.explicit:
            return "take shorter steps (time.fraction)"
        at_once = "a load that acts from the first step on does its work in one step"
        return f"{at_once}: give loads a ramp, or take more steps (integrator.steps)"
    (pair,) = (pair for pair in model.contact.pairs if pair.name == one.where)  # type: ignore[union-attr]
    if one.code == "kept-overlap":
        if model.integrator.inertia:
            return 'take the side with shorter segments as slave (swap), refine it, or set forces = "frozen"'
        part = pair.method if pair.by_energy else model.contact.enforcement  # type: ignore[union-attr]
        return (
            f"make {type(part).__name__} {one.value / one.limit:.2g} times as stiff, refine the cells, or take contact "
            'without springs (mortar-p1, enforcement = "active-set")'
        )
    own, other = (float(side.lengths(at).mean()) for side, at in zip((pair.slave, pair.master), pair.at, strict=True))
    if other > COARSER * own:
        return (
            f"segments of the master are {other / own:.2g} times as long as segments of the slave, and press with "
            "their ends: shorten them (cells of its body, or `segment` of a rigid surface)"
        )
    if pair.method.passes_patch_test:
        return f"{FINER}; pressures add up to the forces, and nodal_pressure alternates less"
    return f'write {one.where}.algorithm = "mortar-p1", or refine the master (level)'


def _share(value: float) -> str:
    return f"{value:.2g}" if not 1e-4 <= value < 10.0 else f"{value:.2%}" if value < 0.095 else f"{value:.0%}"
