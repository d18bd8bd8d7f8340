"""Cattaneo and Mindlin: a cylinder that is pressed, pushed sideways, and pushed back to the other side, mu = 0.3.

Both bodies are of the same material, so that normal and tangential problems are uncoupled. Shear follows the exact
solution at the measured forces; on the way back that of the loading and twice that of what was taken off.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from statics.common import (
    INF,
    MORTARS,
    Figure,
    Rows,
    l2_error,
    label,
    ordered,
    percent,
    plane_strain,
    stopped,
    within,
)
from statics.hertz import hertz, hertz_profile, side

from contactlab.api import ContactCurve, Floats
from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene

FRICTION, RADIUS, MODULUS = 0.3, 10.0, plane_strain(70000.0, 0.3) / 2.0
PHASES = {2: "loaded", 3: "half-way back", 4: "reversed"}


def mindlin(algorithm: str, swap: bool, shift: float = 2.6e-4, steps: int = 16, **keys: Any) -> Scene:
    """Pressed until t = 1, pushed sideways until 2, back through the middle at 3 to the other side at 4.

    P is 100 N/mm and Q close to a half of mu P, so that the inner seventy percent of the contact stick.
    """
    way = [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 0.0], [4.0, -1.0]]
    depth = keys.pop("depth", 8.59e-4)
    top = {
        "on": "disc.top",
        "ux": {"ramp": "table", "to": shift * RADIUS, "points": way},
        "uy": {"ramp": "linear", "to": -depth * RADIUS, "duration": 1.0},
    }
    contact = {"friction": {"use": "coulomb", "mu": FRICTION}}
    made = hertz(algorithm, swap, RADIUS, supports=[top], contact=contact, time={"end": 4.0}, steps=steps, **keys)
    return made.with_({"record.frames": 4})


def mindlin_figures(results: Results, judged: bool = True) -> list[Figure]:
    """Of loading, half-way back, and full reversal."""
    fy, fx = (results.history[f"block.bottom.{component}"] for component in ("fy", "fx"))
    history = results.contact["contacts.0"]
    found = [Figure("Q/(mu P)", abs(float(fx[2])) / (FRICTION * float(fy[2])))]
    for time, curve in zip(history.times, history.curves, strict=True):
        frame = round(time)
        if frame < 2:
            continue
        a, _, _ = hertz_profile(float(fy[frame]), RADIUS, MODULUS)
        if frame == 2:
            found += stick_width(curve, a, np.sqrt(1.0 - abs(float(fx[2])) / (FRICTION * float(fy[2]))) * a, judged)
        exact = partial_slip(float(fy[frame]), float(fx[frame]), a, float(fx[2]) if frame > 2 else None)
        found += shear_figures(curve, a, exact, PHASES[frame], 6.0 if judged and frame == 2 else INF)
    contact = results.summary["contacts"]["contacts.0"]
    balance = abs(float(contact["resultant"][0])) / abs(float(fx[-1])) - 1.0
    return [
        *found,
        within("resultant of q over Q, less 1", balance, 1e-6),
        Figure("cone violation", float(contact["cone_violation"]), most=1e-12),
        Figure("iterations", float(results.summary["iterations"])),
    ]


def shear_figures(
    curve: ContactCurve, a: float, exact: Callable[[Floats], Floats], phase: str, most: float
) -> list[Figure]:
    """Peak and L2 of q, beside what the exact values at these nodes would give."""
    x, wanted = centred(curve), exact(np.linspace(-a, a, 2001))
    q = np.sign(float(np.interp(0.0, *ordered(x, curve.shear))) * float(exact(np.zeros(1))[0])) * curve.shear
    return [
        percent(f"{phase}: peak", float(np.abs(q).max() / np.abs(wanted).max() - 1.0), most),
        percent(f"{phase}: L2", l2_error(x, q, exact, 2.0 * a)),
        percent(f"{phase}: L2 of exact nodal values", l2_error(x, exact(x), exact, 2.0 * a)),
    ]


def centred(curve: ContactCurve) -> Floats:
    """x from the middle of the pressure: the disc is sheared, so that its contact rolls on by 1 % of a or two."""
    middle = float((curve.x * curve.pressure).sum() / curve.pressure.sum())
    return np.asarray(curve.x - middle)


def stick_width(curve: ContactCurve, a: float, c: float, judged: bool) -> list[Figure]:
    """Against Mindlin's c, half of the way between the middles of the segments on which sticking ends."""
    x, state = ordered(centred(curve), curve.state)
    size = float(np.diff(x[np.abs(x) < 1.2 * a]).mean())
    stuck = np.flatnonzero(state == 1)
    width = 0.25 * float(x[stuck[-1]] + x[stuck[-1] + 1] - x[stuck[0]] - x[stuck[0] - 1])
    return [Figure("a/h", a / size), within("stick half-width / h", (width - c) / size, 1.0 if judged else INF)]


def partial_slip(force: float, side: float, a: float, before: float | None) -> Callable[[Floats], Floats]:
    """q(x) at a tangential force `side`; after unloading from `before` the slip of the way back is taken off twice."""
    limit = FRICTION * 2.0 * force / (np.pi * a)

    def loaded(at: Floats, amount: float) -> Floats:
        c = a * np.sqrt(max(0.0, 1.0 - abs(amount) / (FRICTION * force)))
        full = np.sqrt(np.maximum(0.0, 1.0 - at**2 / a**2))
        core = np.sqrt(np.maximum(0.0, c**2 - at**2)) / a
        return np.asarray(np.sign(amount) * limit * (full - core))

    if before is None:
        return lambda at: loaded(at, side)
    return lambda at: loaded(at, before) - 2.0 * loaded(at, 0.5 * (before - side))


def case_mindlin() -> Rows:
    """a/h = 16 on both bodies, twice and half of it, either slave; then other numbers of load steps."""
    variants = [(alg, swap, 16, 16) for alg in MORTARS for swap in (False, True)]
    variants += [("mortar-p0", False, 8, 16), ("mortar-p0", False, 32, 16), ("mortar-p0", False, 16, 4)]
    for algorithm, swap, cells, steps in variants:
        made = mindlin(algorithm, swap, h=0.0182 / cells, growth=1.015, zone=0.024, steps=steps)
        results = simulate(made)
        variant = label(algorithm, side(swap), f"a/h = {cells}", f"{steps} steps")
        yield variant, stopped(results) or mindlin_figures(results, cells == 16)
