"""Static scenes with exact answers, both mortars, either slave: `python statics_cases.py [CASE ...]` prints rows.

Loads are prescribed displacements; closed forms are evaluated at the forces that are measured with them, so that the
compliance of the finite bodies plays no part.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from contactlab.api import ContactCurve, Floats
from contactlab.results.results import Results
from contactlab.scene import Scene
from contactlab.simulation import simulate

Row = tuple[str, dict[str, float]]
MORTARS = ("mortar-p0", "mortar-p1")


def scene(name: str, steps: int, materials: dict[str, Any], contact: dict[str, Any], **more: Any) -> Scene:
    """Materials are linear elastic unless they say otherwise."""
    base = {"use": "linear-elastic", "density": 1.0}
    data = {
        "name": name,
        "integrator": {"use": "newton", "steps": steps},
        "materials": {key: base | values for key, values in materials.items()},
        "contacts": [contact],
        "record": {"recorders": [], "frames": 1},
    }
    return Scene.from_data(data | more)


def plane_strain(young: float, poisson: float) -> float:
    """E/(1 - nu^2) [MPa]."""
    return young / (1.0 - poisson**2)


def spread(x: Floats, values: Floats, reach: float) -> tuple[Floats, Floats]:
    """The linear interpolant at many points of |x| < reach."""
    at, order = np.linspace(-reach, reach, 4001), np.argsort(x)
    return at, np.interp(at, x[order], values[order])


def l2_error(x: Floats, values: Floats, exact: Callable[[Floats], Floats], reach: float) -> float:
    """Relative L2 difference over |x| < reach."""
    at, found = spread(x, values, reach)
    wanted = exact(at)
    return float(np.sqrt(((found - wanted) ** 2).sum() / (wanted**2).sum()))


# --- Hertz: a cylinder on a block -------------------------------------------------------------------


def hertz(
    algorithm: str, swap: bool, radius: float = 10.0, moduli: tuple[float, float] = (70000.0, 70000.0), **keys: Any
) -> Scene:
    """Arc of `radius` on a block 4 x 4 radii wide; h in contact is about radius * `h` on the block, `ratio` h above."""
    h, ratio = keys.pop("h", 0.00114), keys.pop("ratio", 1.0)
    depth, poisson, steps = keys.pop("depth", 8e-4), keys.pop("poisson", 0.3), keys.pop("steps", 1)
    zone, elements = keys.pop("zone", 0.03), keys.pop("element", "q1")
    fine = max(2, round(2.0 * zone / h))
    outside = 16
    growth = 2.0 / h / outside * 2.0
    half = 0.4  # of the disc
    columns = graded_count(half, h * ratio, 1.045)
    rows = graded_count(0.5, h * ratio, 1.12)
    bodies = {
        "disc": {
            "element": elements,
            "material": "upper",
            "mesh": {
                "use": "arc-block", "radius": radius, "half_width": half * radius, "top": 0.5 * radius,
                "cells": [2 * columns, rows], "grading": [1.045 ** (columns - 1), 1.12 ** (rows - 1)],
            },
        },
        "block": {
            "element": elements,
            "material": "lower",
            "mesh": {
                "use": "rectangle",
                "x": [-2.0 * radius, -zone * radius, zone * radius, 2.0 * radius],
                "y": [-4.0 * radius, 0.0],
                "cells": [[outside, fine, outside], graded_count(4.0, h, 1.15)],
                "grading": [[1.0 / growth, 1.0, growth], 1.15 ** -(graded_count(4.0, h, 1.15) - 1)],
            },
        },
    }  # fmt: skip
    contact = {"slave": "disc.arc", "master": "block.top", "algorithm": algorithm, "swap": swap}
    contact |= keys.pop("contact", {})
    supports = keys.pop("supports", [{"on": "disc.top", "ux": 0.0, "uy": -depth * radius}])
    materials = {
        "upper": {"young": moduli[0], "poisson": poisson},
        "lower": {"young": moduli[1], "poisson": poisson},
    }
    held = [{"on": "block.bottom", "ux": 0.0, "uy": 0.0}]
    return scene("hertz", steps, materials, contact, bodies=bodies, supports=[*held, *supports], **keys)


def graded_count(length: float, first: float, growth: float) -> int:
    """Cells of growing size from `first` on that fill a length."""
    return max(2, round(np.log(1.0 + length / first * (growth - 1.0)) / np.log(growth)))


def hertz_measures(results: Results, radius: float, modulus: float) -> dict[str, float]:
    """Against p = p0 (1 - x^2/a^2)^(1/2) of the measured force."""
    curve = results.contact["contacts.0"].last
    force = float(results.summary["reactions"]["block.bottom"][1])
    a = float(np.sqrt(4.0 * force * radius / (np.pi * modulus)))
    p0 = 2.0 * force / (np.pi * a)
    x, p = curve.x, curve.pressure
    near = np.sort(x[np.abs(x) < 2.0 * a])
    size = float(np.diff(near).mean())
    closed = curve.nodal_pressure > 0.0
    width = 0.5 * float(np.ptp(x[closed]))

    def exact(at: Floats) -> Floats:
        return np.asarray(p0 * np.sqrt(np.maximum(0.0, 1.0 - at**2 / a**2)))

    return {
        "iterations": float(results.summary["iterations"]),
        "a": a,
        "a/h": a / size,
        "p0 error": float(p.max()) / p0 - 1.0,
        "half-width error / h": (width - a) / size,
        "L2 error": l2_error(x, p, exact, 2.0 * a),
    }


def case_hertz() -> Iterator[Row]:
    """NAFEMS CGS-1 (steel on aluminium, R = 50), a/h about 8 and 16; equal and 1:1e4 moduli; mesh ratios 3 and 10."""
    for algorithm in MORTARS:
        for swap in (False, True):
            for h in (0.0155, 0.0078):
                made = hertz(algorithm, swap, 50.0, (210000.0, 70000.0), h=h, zone=0.2, depth=0.012)
                modulus = 1.0 / (0.91 / 210000.0 + 0.91 / 70000.0)
                yield f"CGS-1 {algorithm} swap={swap} h={h}", hertz_measures(simulate(made), 50.0, modulus)


def case_contrast() -> Iterator[Row]:
    """Moduli 1e4 apart, the disc stiff, with cells alike and three times as long."""
    for algorithm in MORTARS:
        for swap in (False, True):
            for ratio in (1.0, 3.0):
                made = hertz(algorithm, swap, 10.0, (7e8, 7e4), ratio=ratio)
                modulus = 1.0 / (0.91 / 7e8 + 0.91 / 7e4)
                yield f"1:1e4 {algorithm} swap={swap} ratio={ratio}", hertz_measures(simulate(made), 10.0, modulus)


def case_mesh_ratio() -> Iterator[Row]:
    """Cells of the disc ten times as long as those of the block."""
    for algorithm in MORTARS:
        for swap in (False, True):
            made = hertz(algorithm, swap, 10.0, ratio=10.0)
            results = simulate(made)
            contact = results.summary["contacts"]["contacts.0"]
            measures = hertz_measures(results, 10.0, plane_strain(70000.0, 0.3) / 2.0)
            reference = simulate(hertz(algorithm, swap, 10.0))
            force, other = (float(r.summary["reactions"]["block.bottom"][1]) for r in (results, reference))
            measures["force against equal meshes"] = force / other - 1.0
            measures["penetration / fine h"] = contact["max_penetration"] / 0.0114
            yield f"10:1 {algorithm} swap={swap}", measures


# --- Cattaneo and Mindlin: tangential load and its reversal -----------------------------------------

FRICTION = 0.3


def mindlin(algorithm: str, swap: bool, shift: float = 4e-4, steps: int = 16, **keys: Any) -> Scene:
    """Pressed until t = 1, pushed sideways until 2, back through the middle at 3 to the other side at 4."""
    way = [[0.0, 0.0], [1.0, 0.0], [2.0, 1.0], [3.0, 0.0], [4.0, -1.0]]
    depth = keys.pop("depth", 8e-4)
    top = {
        "on": "disc.top",
        "ux": {"ramp": "table", "to": shift * 10.0, "points": way},
        "uy": {"ramp": "linear", "to": -depth * 10.0, "duration": 1.0},
    }
    contact = {"friction": {"use": "coulomb", "mu": FRICTION}}
    return hertz(algorithm, swap, 10.0, supports=[top], contact=contact, time={"end": 4.0}, steps=steps, **keys).with_(
        {"record.frames": 4}
    )


def mindlin_measures(results: Results) -> dict[str, float]:
    """Shear after loading, at the middle of the way back, and at its end."""
    fy, fx = (results.history[f"block.bottom.{c}"] for c in ("fy", "fx"))
    modulus, found = plane_strain(70000.0, 0.3) / 2.0, {"iterations": float(results.summary["iterations"])}
    history = results.contact["contacts.0"]
    largest = 0.0
    for time, curve in zip(history.times, history.curves, strict=True):
        frame = round(time)
        if frame < 2:
            continue
        force, side = float(fy[frame]), float(fx[frame])
        a = float(np.sqrt(4.0 * force * 10.0 / (np.pi * modulus)))
        if frame == 2:
            largest = side
            found |= stick_width(curve, a, np.sqrt(1.0 - abs(side) / (FRICTION * force)) * a)
        exact = partial_slip(force, side, a, largest if frame > 2 else None)
        sign = -np.sign(float(np.interp(0.0, *ordered(curve.x, curve.shear))) * float(exact(np.zeros(1))[0]))
        x, q = curve.x, -sign * curve.shear
        found[f"L2 error of q at t={frame}"] = l2_error(x, q, exact, 2.0 * a)
        inside = np.linspace(-a, a, 2001)
        peak = np.abs(exact(inside)).max()
        found[f"peak error at t={frame}"] = float(np.abs(q).max() / peak - 1.0)
    found["cone violation"] = float(results.summary["contacts"]["contacts.0"]["cone_violation"])
    return found


def ordered(x: Floats, values: Floats) -> tuple[Floats, Floats]:
    """By increasing x."""
    order = np.argsort(x)
    return x[order], values[order]


def stick_width(curve: ContactCurve, a: float, c: float) -> dict[str, float]:
    """Against Mindlin's c."""
    x, state = ordered(curve.x, curve.state)
    size = float(np.diff(x[np.abs(x) < a]).mean())
    stuck = x[state == 1]
    return {"c/a": c / a, "a/h": a / size, "stick width error / h": (0.5 * float(np.ptp(stuck)) - c) / size}


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


def case_mindlin() -> Iterator[Row]:
    """Loading and full reversal."""
    for algorithm in MORTARS:
        for swap in (False, True):
            yield f"Mindlin {algorithm} swap={swap}", mindlin_measures(simulate(mindlin(algorithm, swap)))


# --- GRECO: a square plate on a rough plane ---------------------------------------------------------

PUBLISHED = {0.0: 2.86e-5, 1.25e-3: 2.72e-5, 5e-3: 2.28e-5, 7.5e-3: 1.98e-5, 11.25e-3: 1.50e-5}
"""Tangential displacements [m] of SSNV128 (Code_Aster), mu = 1, tolerance 5 %."""


def plate(algorithm: str, mu: float = 1.0, cells: int = 32, steps: int = 1) -> Scene:
    """Metres and pascals: 40 x 40 mm, pressed from above and harder from the left, symmetry on the right."""
    return scene(
        "plate",
        steps,
        {"m": {"young": 1.3e11, "poisson": 0.2}},
        {
            "slave": "plate.bottom",
            "master": "plane",
            "algorithm": algorithm,
            "friction": {"use": "coulomb", "mu": mu},
        },
        bodies={
            "plate": {
                "element": "q1",
                "material": "m",
                "mesh": {"use": "rectangle", "x": [0.0, 0.04], "y": [0.0, 0.04], "cells": [cells, cells]},
            }
        },
        rigid={"plane": {"line": [[0.06, 0.0], [-0.02, 0.0]]}},
        supports=[{"on": "plate.right", "ux": 0.0}],
        loads=[
            {"on": "plate.top", "pressure": 5e7, "follower": False},
            {"on": "plate.left", "pressure": 15e7, "follower": False},
        ],
    )


def plate_measures(results: Results) -> dict[str, float]:
    """Against the published displacements, and the three zones."""
    x0, u = results.nodes[:, 0], results.displacement
    own = np.unique(results.cells["plate"])
    bottom = own[np.isclose(results.nodes[own, 1], 0.0)]
    bottom = bottom[np.argsort(x0[bottom])]
    found = {"iterations": float(results.summary["iterations"])}
    for x, exact in PUBLISHED.items():
        found[f"u({1e3 * x:g})"] = float(np.interp(x, x0[bottom], u[bottom, 0])) / exact - 1.0
    curve = results.contact["contacts.0"].last
    x, state = ordered(curve.x, curve.state)
    found["open until mm"] = 1e3 * float(x[state == 0].max(initial=0.0))
    found["stick from mm"] = 1e3 * float(x[state == 1].min(initial=np.inf))
    return found


def case_plate() -> Iterator[Row]:
    """mu = 1, two meshes."""
    for algorithm in MORTARS:
        for cells in (32, 64):
            yield f"plate {algorithm} cells={cells}", plate_measures(simulate(plate(algorithm, cells=cells)))


def case_high_friction() -> Iterator[Row]:
    """mu = 2 and 5 against 20: as good as unlimited (with 100 and more the iteration fails, and says so)."""
    for algorithm in MORTARS:
        unlimited = simulate(plate(algorithm, 20.0)).displacement
        for mu in (2.0, 5.0):
            results = simulate(plate(algorithm, mu))
            difference = float(np.abs(results.displacement - unlimited).max() / np.abs(unlimited).max())
            iterations = float(results.summary["iterations"])
            found = plate_measures(results)
            zones = {key: found[key] for key in ("open until mm", "stick from mm")}
            yield f"mu={mu} {algorithm}", {"iterations": iterations, "against mu = 20": difference} | zones


# --- flat punches -----------------------------------------------------------------------------------


def punch(algorithm: str, cells: int = 40) -> Scene:
    """A rigid punch of half width 1 on a block 20 x 20, which is the slave; frictionless."""
    return scene(
        "punch",
        1,
        {"m": {"young": 1000.0, "poisson": 0.3}},
        {"slave": "block.top", "master": "punch", "algorithm": algorithm},
        bodies={
            "block": {
                "element": "q1",
                "material": "m",
                "mesh": {
                    "use": "rectangle", "x": [-10.0, -1.5, 1.5, 10.0], "y": [-20.0, 0.0],
                    "cells": [[16, 3 * cells // 2, 16], 40], "grading": [[0.05, 1.0, 20.0], 0.005],
                },
            }
        },
        rigid={
            "punch": {"line": [[-1.0, 1.0], [-1.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "uy": {"ramp": "linear", "to": -1e-4}}
        },
        supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
    )  # fmt: skip


def punch_measures(results: Results) -> dict[str, float]:
    """Against the rigid punch on a half-plane, of the measured force."""
    curve = results.contact["contacts.0"].last
    x, p = ordered(curve.x, curve.pressure)
    force = float(results.summary["reactions"]["block.bottom"][1])

    def exact(at: Floats) -> Floats:
        return np.asarray(force / (np.pi * np.sqrt(np.maximum(1e-9, 1.0 - at**2))))

    return {
        "iterations": float(results.summary["iterations"]),
        "L2 error, |x| < 0.9": l2_error(x, p, exact, 0.9),
        "p(0) / mean": float(np.interp(0.0, x, p)) / (0.5 * force),
        "undershoot / pressure at the corner": float(-p.min() / p.max()),
    }


def case_punch() -> Iterator[Row]:
    """Two meshes."""
    for algorithm in MORTARS:
        for cells in (40, 80):
            yield f"punch {algorithm} cells={cells}", punch_measures(simulate(punch(algorithm, cells)))


# --- nearly incompressible --------------------------------------------------------------------------


def soft_block(algorithm: str, element: str, h: float = 0.05) -> Scene:
    """A rigid cylinder R = 8 on a block 40 x 20, E = 10, nu = 0.499."""
    rows = graded_count(20.0, h, 1.15)
    return scene(
        "soft",
        1,
        {"m": {"young": 10.0, "poisson": 0.499}},
        {"slave": "block.top", "master": "cylinder", "algorithm": algorithm},
        bodies={
            "block": {
                "element": element,
                "material": "m",
                "mesh": {
                    "use": "rectangle", "x": [-20.0, -1.5, 1.5, 20.0], "y": [-20.0, 0.0],
                    "cells": [[14, round(3.0 / h), 14], rows], "grading": [[0.02, 1.0, 50.0], 1.15 ** -(rows - 1)],
                },
            }
        },
        rigid={
            "cylinder": {
                "arc": {"centre": [0.0, 8.0], "radius": 8.0, "angles": [250.0, 290.0]},
                "segment": h,
                "uy": {"ramp": "linear", "to": -0.15},
            }
        },
        supports=[{"on": "block.bottom", "ux": 0.0, "uy": 0.0}],
    )  # fmt: skip


def case_incompressible() -> Iterator[Row]:
    """Three elements; plain q1 is expected to lock."""
    for algorithm in MORTARS:
        for element in ("q1-fbar", "q2-lagrange", "q1"):
            results = simulate(soft_block(algorithm, element))
            measures = hertz_measures(results, 8.0, plane_strain(10.0, 0.499))
            p = ordered(*(results.contact["contacts.0"].last.x, results.contact["contacts.0"].last.pressure))[1]
            measures["oscillation"] = float(np.abs(np.diff(p, 2)).sum() / np.abs(p).sum())
            yield f"nu=0.499 {algorithm} {element}", measures


CASES: dict[str, Callable[[], Iterator[Row]]] = {
    "hertz": case_hertz,
    "mindlin": case_mindlin,
    "punch": case_punch,
    "plate": case_plate,
    "friction": case_high_friction,
    "contrast": case_contrast,
    "incompressible": case_incompressible,
    "ratio": case_mesh_ratio,
}


def main(names: list[str]) -> None:
    """Print the rows of the cases named, or of all."""
    for name in names or list(CASES):
        for label, measures in CASES[name]():
            print(label, " ".join(f"{key}: {value:.4g}" for key, value in measures.items()), sep=" | ", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
