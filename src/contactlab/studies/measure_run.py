"""Numbers of a row from the summary and the curve of one run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.jobs.rows import number
from contactlab.results.peaks import peak_force, peak_pressure
from contactlab.results.results import ContactCurve
from contactlab.studies import measures as m
from contactlab.studies.profile import FoldedSurfaceError, Profile
from contactlab.studies.reference import Reference

Measures = dict[str, float]
NEARLY = 1.0 - 1e-9
"""Share of the load that is all of it, but for round-off."""


def applied_share(summary: Mapping[str, Any]) -> float:
    """Share of the load (statics) or of the declared time that a run came to, 0 to 1; 1 if its summary has none."""
    return float(summary.get("reached", {}).get("share", 1.0))


def carried_load(status: str, share: float) -> bool:
    """Return whether a run applied its whole load, settled or not."""
    return status == "finished" or (status == "not-converged" and share >= NEARLY)


def measure_run(
    scene: Mapping[str, Any],
    summary: Mapping[str, Any],
    contact: int,
    curve: ContactCurve | None,
    reference: Reference | None,
) -> tuple[Measures, list[str]]:
    """All measures of one run that need no other run, and notes on missing measures.

    scene    TOML data with defaults written out
    summary  content of `summary.json`; may be empty when the process died
    contact  number of the contact whose `curve` is compared
    """
    found = _costs(summary) | _forces(scene, summary, contact)
    found["reaction_error"] = _reaction_error(found["reaction"], reference)
    notes: list[str] = []
    if curve is not None and len(curve.x):
        try:
            profile = Profile.of_curve(curve)
        except FoldedSurfaceError as error:
            notes.append(str(error))
        else:
            found |= _pressures(profile, reference, mirrored=scene.get("symmetry") == "x")
    return found, notes


def _pressures(profile: Profile, reference: Reference | None, mirrored: bool) -> Measures:
    found: Measures = {}
    if mirrored:
        found["mirror_asymmetry"] = m.mirror_asymmetry(profile)
    if reference is not None:
        exact, window = reference.profile, reference.window
        found["pressure_error"] = m.pressure_error(profile, exact, window)
        found["largest_pressure_error"] = m.largest_pressure_error(profile, exact, window)
        found["oscillation"] = m.oscillation(profile, exact)
        found["turning_points"] = m.excess_turning_points(profile, exact)
        found["edge_error"] = m.edge_error(profile, exact)
    return found


# --- forces ----------------------------------------------------------------------------------------


def _forces(scene: Mapping[str, Any], summary: Mapping[str, Any], contact: int) -> Measures:
    reactions = {on: np.asarray(force, float) for on, force in summary.get("reactions", {}).items()}
    facts = summary.get("contacts", {}).get(f"contacts.{contact}", {})
    resultant, integral = (_vector(facts.get(name)) for name in ("resultant", "pressure_integral"))
    driven = driven_support(scene, reactions)
    force = peak_force(summary, driven or f"contacts.{contact}") or {}
    pressure = peak_pressure(summary, f"contacts.{contact}") or {}
    depths = [number(facts.get("max_penetration")) for facts in summary.get("contacts", {}).values()]
    deepest = max(depths, default=math.nan)
    return {
        "reaction": _length(reactions.get(driven)),
        "peak_force": number(force.get("value")),
        "peak_force_time": number(force.get("time")),
        "reaction_mismatch": number(summary.get("reaction_mismatch")),
        "reaction_against_pressure": reaction_against_pressure(scene, reactions, contact, integral),
        "sideways_force": _quotient(abs(resultant[0]), abs(resultant[1])),
        "peak_pressure": number(pressure.get("value")),
        "peak_pressure_time": number(pressure.get("time")),
        "max_pressure": number(facts.get("max_pressure")),
        "max_penetration": deepest,
    }


def driven_support(scene: Mapping[str, Any], reactions: Mapping[str, Floats]) -> str:
    """The first support that moves; if none does, the support with the largest force."""
    for support in scene.get("supports", ()):
        if any(isinstance(support.get(name), Mapping) for name in ("ux", "uy")):
            return str(support["on"])
    return max(reactions, key=lambda on: _length(reactions[on]), default="")


def reaction_against_pressure(
    scene: Mapping[str, Any], reactions: Mapping[str, Floats], contact: int, integral: Floats
) -> float:
    """|R + P| / |R| with the integral P (2,) of the contact tractions on the slave and the support force R
    on the slave's body; with -P and the master's body if the slave's has no support, or a load.

    nan if both bodies are free, loaded or have other contacts as well, and for a body that touches itself: its contact
    force is internal.
    """
    slave, master = sides(scene["contacts"][contact]) if scene.get("contacts") else ("", "")
    if body_of(slave) == body_of(master):
        return math.nan
    for surface, force in ((slave, integral), (master, -integral)):
        body = body_of(surface)
        held = [value for on, value in reactions.items() if body_of(on) == body and not _is_loaded(scene, body)]
        if held and sum(body in {body_of(surface) for surface in sides(c)} for c in scene.get("contacts", ())) == 1:
            support = np.sum(held, axis=0)
            return _quotient(_length(support + force), _length(support))
    return math.nan


def _is_loaded(scene: Mapping[str, Any], body: str) -> bool:
    """Return whether loads or effects push on a body beside supports and contacts."""
    acting = [effect.get("on") or list(scene["bodies"]) for effect in scene.get("effects", ())]
    acting += [load["on"] for load in scene.get("loads", ())]
    return any(body in map(body_of, [on] if isinstance(on, str) else on) for on in acting)


def sides(contact: Mapping[str, Any]) -> tuple[str, str]:
    """Slave and master surface as they act, `swap` taken into account."""
    slave, master = (
        side if isinstance(side, str) else " + ".join(side) for side in (contact["slave"], contact["master"])
    )
    return (master, slave) if contact.get("swap") else (slave, master)


def body_of(surface: str) -> str:
    """Name of the body in "body.edge_set"."""
    return surface.partition(".")[0]


def _reaction_error(reaction: float, reference: Reference | None) -> float:
    if reference is None:
        return math.nan
    exact = reference.scalar("reaction")
    return _quotient(abs(reaction - exact), abs(exact))


# --- costs -----------------------------------------------------------------------------------------


def _costs(summary: Mapping[str, Any]) -> Measures:
    cost, balance = summary.get("cost", {}), summary.get("balance", {})
    steps, sweeps = number(summary.get("steps")), number(summary.get("contact_sweeps"))
    solved_with_the_bodies = sweeps == 0.0 and summary.get("iterations")
    return {
        "steps": steps,
        "sweeps": math.nan if solved_with_the_bodies else _quotient(sweeps, steps),
        "cpu_s": without_compilation(cost, "run_cpu_s"),
        "wall_s": without_compilation(cost, "run_wall_s"),
        "memory_mib": number(cost.get("peak_memory_mib")),
        "kinetic_share": _quotient(number(balance.get("kinetic")), abs(number(balance.get("internal")))),
    }


def without_compilation(cost: Mapping[str, Any], name: str) -> float:
    """Seconds without the compiling and loading of kernels: that is no property of an algorithm."""
    return float(np.maximum(number(cost.get(name)) - number(cost.get("compile_s", 0.0)), 0.0))


def _vector(value: Any) -> Floats:
    return np.full(2, np.nan) if value is None else np.asarray(value, float)


def _length(vector: Floats | None) -> float:
    return math.nan if vector is None else float(np.hypot(*vector))


def _quotient(numerator: float, denominator: float) -> float:
    return float(numerator / denominator) if denominator > 0.0 else math.nan
