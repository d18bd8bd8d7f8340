"""What no run may break, whatever a case asks: looked for in every record by one function."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contactlab.api import ContactCurve, Measure, Record
from contactlab.api.case import invariant, reported

LEDGER = 1e-6
DEEP = 0.5
ROUND = 1e-6

FINITE = invariant("numbers that are not finite", 0.0, "a finished run has none")
LEDGER_ERROR = invariant(
    "energy ledger, error", LEDGER, "works and energies of one scheme add up but for round-off over all steps"
)
SIGN = invariant(
    "pull of a contact node over the largest push", ROUND, "nodal forces push, but for the solver's residual"
)
BALANCE = "resultant against integral of the pressure"
EQUILIBRIUM = invariant("support reactions out of balance", 1e-6, "Newton's tolerance on forces is 1e-8 of the largest")
PENETRATION = invariant(
    "largest penetration of either side in segments", DEEP, "half a segment is where a run is stopped"
)
SAW = reported("saw of the pressure")


def invariants_of(done: Mapping[str, Record]) -> list[tuple[Measure, float]]:
    """The worst of each invariant over all runs of a cell, by what is allowed of it."""
    worst: dict[str, tuple[Measure, float]] = {}
    for record in done.values():
        for measure, value in _of(record):
            before = worst.get(measure.name)
            if before is None or _share(measure, value) > _share(*before):
                worst[measure.name] = measure, value
    return list(worst.values())


def _share(measure: Measure, value: float) -> float:
    return value / measure.most if 0.0 < measure.most < np.inf else value


def _of(record: Record) -> Iterator[tuple[Measure, float]]:
    summary = record.summary
    balance = summary.get("balance", {})
    yield FINITE, float(sum(not np.isfinite(balance.get(name, 0.0)) for name in ("internal", "external")))
    yield LEDGER_ERROR, abs(balance.get("ledger_error", 0.0))
    static, mismatch = balance.get("kinetic") == 0.0, summary.get("reaction_mismatch", np.nan)
    if static and np.isfinite(mismatch):
        yield EQUILIBRIUM, float(mismatch)
    for name, contact in summary.get("contacts", {}).items():
        yield SIGN, float(contact["cone_violation"])
        if record.curves.get(name):
            yield from _of_curve(record, name)


def _of_curve(record: Record, name: str) -> Iterator[tuple[Measure, float]]:
    curve, contact = record.curve(name), record.summary["contacts"][name]
    lengths = np.hypot(np.diff(curve.x), np.diff(curve.y))
    pressure = np.nan_to_num(np.asarray(curve.pressure, float))
    if not len(lengths) or not pressure.max(initial=0.0) > 0.0:
        return
    yield PENETRATION, float(contact["max_penetration"]) / float(np.median(lengths))
    resultant, integral = (np.array(contact[key], float) for key in ("resultant", "pressure_integral"))
    if np.hypot(*resultant) > 0.0:
        yield _balance(curve), float(np.hypot(*(resultant - integral)) / np.hypot(*resultant))
    yield SAW, saw(pressure)


def _balance(curve: ContactCurve) -> Measure:
    """Pressures act along each segment's normal, nodal forces along averaged ones: apart by the square of the angle
    between segments. A multiplier beyond an edge of cover stands for less length than its segment has: only told."""
    if np.any(np.isnan(curve.gap) & (curve.pressure != 0.0)):
        return reported(BALANCE)
    pressed = np.flatnonzero(curve.nodal_pressure > 0.0)
    inner = pressed[(pressed > 0) & (pressed < len(curve.x) - 1)]
    inner = inner[curve.chain[inner - 1] == curve.chain[inner + 1]]
    angle = np.arctan2(np.diff(curve.y), np.diff(curve.x))
    turn = np.abs(np.remainder(angle[inner] - angle[inner - 1] + np.pi, 2.0 * np.pi) - np.pi)
    most = max(ROUND, float(turn.max(initial=0.0)) ** 2)
    return invariant(BALANCE, most, "of the same multipliers, along normals that differ by a segment's turn")


def saw(pressure: np.ndarray) -> float:
    """What of a pressure (m,) alternates from node to node, over its largest value.

    Fourth differences keep what alternates (16 times) and drop cubics.
    """
    inner = np.flatnonzero(pressure > 0.25 * pressure.max())
    inner = inner[(inner >= 2) & (inner < len(pressure) - 2)]
    if len(inner) < 4:
        return 0.0
    p, k = pressure, inner
    ripple = (p[k - 2] - 4.0 * p[k - 1] + 6.0 * p[k] - 4.0 * p[k + 1] + p[k + 2]) / 16.0
    return float(abs(np.mean(ripple * (-1.0) ** k)) / p.max())
