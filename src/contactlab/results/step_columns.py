"""Names of the scalars of every step, in the order of their columns."""

from __future__ import annotations

from collections.abc import Sequence

from contactlab.api.state import CONTACT_WORK, WORK

COUNTS = ("step", "time", "dt", "sweeps", "iterations", "residual", "cost.elements", "cost.contact")
"""Step number, time and length [s], contact sweeps, Newton iterations, contact residual, wall time of the
step's stresses and forces and of its contact [s]."""

CHANGED = "changed"
CONTACT = ("active", "sticking", "penetration", CHANGED)
"""Columns of each contact: conditions with a force, sticking conditions, largest violation at the end of the
step [mm]: zero up to the solver's tolerance if multipliers are exact (`max_penetration` of stored frames
is geometric: nodes and segment middles of either side), and how many conditions changed between open, stick and slip
in the step."""


def step_columns(supports: Sequence[str], contacts: Sequence[str], contact_work: bool = False) -> tuple[str, ...]:
    """Columns of a model with these supports and contacts; with `contact_work` the work of contact by its parts."""
    energies = tuple(f"energy.{name}" for name in ("kinetic", *WORK))
    reactions = tuple(f"{on}.{component}" for on in supports for component in ("fx", "fy"))
    of_contacts = tuple(f"{name}.{what}" for name in contacts for what in CONTACT)
    parts = tuple(f"energy.contact.{part}" for part in CONTACT_WORK) if contact_work else ()
    return COUNTS + energies + reactions + of_contacts + parts
