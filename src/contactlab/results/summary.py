"""Gathers the content of `summary.json`: outcome, cost, reactions, contacts, energy balance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import Layout
from contactlab.model.model import Model
from contactlab.results.cost import Clock, cost_of
from contactlab.results.force_curve import IN_TIME, QUASI_STATIC, THE_END_ONLY
from contactlab.results.invariants import invariants
from contactlab.results.reaction_balance import reaction_mismatch
from contactlab.results.sample import Sample

if TYPE_CHECKING:
    from contactlab.results.contact_report import ContactReport

FORMAT = 1


@dataclass
class Counts:
    """Work done so far: accepted steps, Newton iterations and contact sweeps; sweeps at the last stored frame."""

    steps: int = 0
    iterations: int = 0
    sweeps: int = 0
    sweeps_stored: int = 0

    def saved(self) -> dict[str, Floats]:
        """The counts as an array, for a checkpoint."""
        return {"counts": np.array([self.steps, self.iterations, self.sweeps, self.sweeps_stored], np.float64)}

    def restore(self, memory: Mapping[str, Floats]) -> None:
        """Go back to where `memory` was saved."""
        self.steps, self.iterations, self.sweeps, self.sweeps_stored = (int(n) for n in memory["counts"])


def summarise(
    layout: Layout,
    model: Model,
    sample: Sample | None,
    status: str,
    reason: str,
    counts: Counts,
    clock: Clock,
    largest_force: float = 0.0,
) -> dict[str, Any]:
    """Gather everything of `summary.json` (docs/scene-format.md); `largest_force` [N] of the run."""
    return {
        "format": FORMAT,
        "scene": layout.title,
        "resolved": model.timing.resolved(),
        "history": {
            "matters": bool(model.history),
            "because": list(model.history.because),
            "curve": curve_of(model),
        },
        "status": status,
        "reason": reason,
        "parts": dict(layout.parts),
        "versions": dict(layout.versions),
        "steps": counts.steps,
        "iterations": counts.iterations,
        "contact_sweeps": counts.sweeps,
        "nodes": len(model.reference),
        "cells": sum(len(body.cells) for body in model.bodies),
        "cost": cost_of(model, clock, layout, status),
        "reactions": {} if sample is None else {on: list(force) for on, force in sample.reactions.items()},
        "reaction_mismatch": reaction_mismatch(model),
        "contacts": {}
        if sample is None
        else {name: _contact(c) | _derived(model, name) | _start(model, name) for name, c in sample.contacts.items()},
        "balance": {} if sample is None else _balance(sample),
        "invariants": [] if sample is None else [one.as_data() for one in invariants(model, sample, largest_force)],
    }


def curve_of(model: Model) -> str:
    """Kind of the stored states before the end: a motion in time, equilibria, or neither."""
    if model.history.motion:
        return IN_TIME
    return QUASI_STATIC if model.way_followed and model.timing.follows else THE_END_ONLY


def _contact(report: ContactReport) -> dict[str, Any]:
    memory = report.curve.memory
    return {
        "resultant": list(report.resultant),
        "pressure_integral": list(report.covered_integral),
        "intervals": report.intervals,
        "max_pressure": float(report.curve.pressure.max(initial=0.0)),
        "max_nodal_pressure": float(report.curve.nodal_pressure.max(initial=0.0)),
        "max_penetration": report.max_penetration,
        "penetrating_side": report.penetrating_side,
        "cone_violation": report.cone_violation,
        "complementarity": report.complementarity,
        "most_negative": report.most_negative,
        "active": report.active,
        "sticking": report.sticking,
    } | ({"memory": {name: _ends(values) for name, values in memory.items()}} if memory else {})


def _ends(values: Floats) -> dict[str, float]:
    return {"least": float(values.min()), "most": float(values.max())}


def _derived(model: Model, name: str) -> dict[str, Any]:
    """Values that implicit contact derived from the bodies: least and largest stiffness of a condition [N/mm].

    Potentials set no conditions: no complementarity residual exists.
    """
    conditions: Any = getattr(model.contact, "conditions", None)
    if conditions is None or model.contact is None:
        return {}
    (pair,) = (pair for pair in model.contact.pairs if pair.name == name)
    if pair.by_energy:
        return {"stiffness": None, "complementarity": None}
    own = pair.own
    stiffness = conditions.stiffness[own][conditions.present[own]]
    return {"stiffness": [float(stiffness.min()), float(stiffness.max())] if len(stiffness) else []}


def _start(model: Model, name: str) -> dict[str, Any]:
    """Treatment of initial gaps [mm]: least and largest that count as zero, overlap by facets, opening."""
    for pair in model.contact.pairs if model.contact is not None else ():
        if pair.name == name and (start := pair.start_gaps) is not None:
            if start.lasting:
                return {"start_distance": [float(start.value.min()), float(start.value.max())]}
            if start.opened:
                return {"opened": start.opened}
            return {"facet_overlap": -float(start.value.min())} if start.by_facets else {}
    return {}


def _balance(sample: Sample) -> dict[str, float]:
    e = sample.energies
    stored = e["stored"]
    scale = max(abs(e["kinetic"]) + abs(e["internal"]) + abs(e["external"]), 1e-300)
    return {
        "kinetic": e["kinetic"],
        "stored": stored,
        "internal": e["internal"],
        "plastic": e["plastic"],
        "friction": -e["friction"],
        "external": e["external"],
        "damping": e["damping"],
        "contact": e["contact"],
        "numerical": e["numerical"],
        "ledger_error": e["error"],
        "stored_against_work": abs(e["internal"] - stored - e["plastic"]) / scale,
    }
