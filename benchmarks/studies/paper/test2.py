"""Test 2 of the paper, block on a rigid plane with Tresca friction: figures 13 to 15."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from common import COLOURS, GREY, SHORT, Numbers, curve, percent, picture
from common import run as kept_run
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from scipy.optimize import curve_fit
from scipy.stats import t as student

import contactlab
from contactlab.api import Record
from contactlab.api.drawing.colours import FIELD
from contactlab.scene.scene import Scene
from contactlab.studies.energy_norm import energy_distance, energy_norm

ALGORITHMS = ("mortar-p0", "mortar-p1", "node-on-segment")
READINGS = {"everywhere": "bound everywhere", "closed": "only where pressed"}
COARSE, FINEST = 0.1, 16  # mm, segment of the coarsest mesh; level of the reference, 39936 elements
LEVELS = (0, 1, 2, 4, 8)  # 0 is half of 1


def scene(algorithm: str, where: str, level: int) -> Scene:
    """The bundled scene; level 0 has half the cells of level 1 in each direction."""
    changes: dict[str, Any] = {
        "contacts.0.algorithm": algorithm, "contacts.0.friction.where": where, "level": max(level, 1),
        "integrator.tolerance": 1e-10,
    }  # fmt: skip
    if level == 0:
        changes["bodies.block.mesh.cells"] = [13, 3]
    return contactlab.load_scene("tresca-block").with_(changes)


@cache
def run(algorithm: str, where: str, level: int) -> Record:
    """One solution, made once."""
    results = kept_run(scene(algorithm, where, level))
    if results.status != "finished":
        print(f"{algorithm}, {where}, level {level}: {results.status}, {results.reason}")
    return results


def size(level: int) -> float:
    """Segment length [mm]."""
    return COARSE if level == 0 else 0.5 * COARSE / level


def start(results: Record) -> Any:
    """Undeformed x of the slave's nodes [mm]."""
    return np.linspace(0.0, 1.3, len(curve(results).x))


def figure_13() -> Numbers:
    """Vertical displacement, both readings of the bound."""
    runs = {where: run("mortar-p0", where, 4) for where in READINGS}
    colours = LinearSegmentedColormap.from_list("field", FIELD)

    def fill(figure: Figure, axes: Any) -> None:
        for place, (where, results) in zip(axes[:, 0], runs.items(), strict=True):
            cells, u = results.cells["block"], results.displacement
            x = results.nodes + 20.0 * u
            shapes = PolyCollection(
                x[cells], array=1e3 * u[cells, 1].mean(axis=1), cmap=colours, edgecolors="face", linewidths=0.2
            )
            shapes.set_clim(-2.0, 2.3)
            shapes.set_rasterized(True)
            place.add_collection(shapes)
            place.axhline(0.0, color=GREY, linewidth=1.0)
            place.set(xlim=(-0.02, 1.33), ylim=(-0.02, 0.38), aspect="equal", title=READINGS[where], ylabel="y [mm]")
            figure.colorbar(shapes, ax=place, label="u_y [µm]", shrink=0.9)
        axes[-1, 0].set_xlabel("x [mm], displacements 20 times enlarged")

    picture("figure-13", 2, 1, fill, (7.5, 4.6))
    numbers: Numbers = {}
    for where, results in runs.items():
        closed = start(results)[np.asarray(curve(results).nodal_pressure) > 0.0]
        numbers[f"end_{where}"] = f"{closed.max():.4f}"
        numbers[f"lift_{where}"] = f"{1e3 * np.max(curve(results).gap):.2f}"
    fine = run("mortar-p0", "everywhere", 8)
    numbers["end_fine"] = f"{start(fine)[np.asarray(curve(fine).nodal_pressure) > 0.0].max():.4f}"
    nodes = run("node-on-segment", "everywhere", 4)
    numbers["lift_nodes"] = f"{1e3 * np.max(curve(nodes).gap):.2f}"
    return numbers


def rate(sizes: Any, errors: Any, reference: float) -> tuple[float, float]:
    """Exponent r of d^2 = C^2 (h^2r - h_ref^2r), the error that a reference of size h_ref lets see, and its 95 %
    half-interval."""

    def model(h: Any, scale: float, power: float) -> Any:
        return scale + 0.5 * np.log(h ** (2 * power) - reference ** (2 * power))

    found, covariance = curve_fit(model, np.asarray(sizes), np.log(errors), p0=(0.0, 0.5))
    spread = student.ppf(0.975, len(sizes) - 2) * np.sqrt(covariance[1, 1])
    return float(found[1]), float(spread)


def figure_14() -> Numbers:
    """Errors in the energy norm against the finest mesh."""
    sizes = [size(level) for level in LEVELS]
    errors: dict[tuple[str, str], list[float]] = {}
    numbers: Numbers = {"elements": str(26 * 6 * FINEST**2)}
    for where in READINGS:
        reference, fine = run("mortar-p0", where, FINEST), scene("mortar-p0", where, FINEST)
        whole = energy_norm(reference, fine, "block")
        for algorithm in ALGORITHMS:
            errors[where, algorithm] = [
                energy_distance(run(algorithm, where, level), reference, fine, "block") / whole for level in LEVELS
            ]
            found, spread = rate(sizes, errors[where, algorithm], size(FINEST))
            plain = np.polyfit(np.log(sizes), np.log(errors[where, algorithm]), 1)[0]
            short = algorithm.replace("-", "_")
            numbers[f"rate_{where}_{short}"] = f"{found:.3f} ± {spread:.3f}"
            numbers[f"plain_{where}_{short}"] = f"{plain:.2f}"
        pair = [np.array(errors[where, algorithm]) for algorithm in ALGORITHMS[:2]]
        numbers[f"apart_{where}"] = percent(float(np.abs(pair[0] / pair[1] - 1.0).max()))
    numbers["finest"] = percent(errors["everywhere", "mortar-p0"][-1])
    numbers["apart_nodes"] = percent(
        abs(errors["everywhere", "node-on-segment"][-1] / errors["everywhere", "mortar-p0"][-1] - 1.0)
    )

    def fill(figure: Figure, axes: Any) -> None:
        for place, where in zip(axes[0], READINGS, strict=True):
            for algorithm, marker, width in zip(ALGORITHMS, "os^", (6, 3, 3), strict=True):
                place.loglog(
                    sizes, errors[where, algorithm], color=COLOURS[algorithm], marker=marker, markersize=width,
                    label=SHORT[algorithm], linewidth=1.0,
                )  # fmt: skip
            line = errors[where, "mortar-p0"][1] * np.sqrt(np.array(sizes) / sizes[1]) * 0.8
            place.loglog(sizes, line, color=GREY, linestyle="--", linewidth=1.0, label="slope 1/2")
            place.set(title=READINGS[where], xlabel="h [mm]", ylabel="error in the energy norm, relative")
            place.legend(fontsize=8)

    picture("figure-14", 1, 2, fill, (9.0, 3.6))
    return numbers


def figure_15() -> Numbers:
    """Normal and tangential stress of P0 for several h; the dip below zero at the edge of contact."""
    levels = (1, 2, 4, 8)
    runs = {level: run("mortar-p0", "everywhere", level) for level in levels}
    shades = dict(zip(levels, ("#9ecae1", "#4292c6", "#2171b5", "#08306b"), strict=True))

    def fill(figure: Figure, axes: Any) -> None:
        for column, place in (("pressure", axes[0][0]), ("shear", axes[0][1])):
            for level, results in runs.items():
                values = np.asarray(getattr(curve(results), column))
                place.plot(start(results), values, color=shades[level], linewidth=1.1, label=f"h = {size(level):g}")
            place.set(xlabel="s from O [mm]", ylabel=f"{column} [MPa]", title=f"{column}, P0, bound everywhere")
            place.legend(fontsize=8)
        axes[0][0].set_ylim(-80, 1000)
        for bound in (-200, 200):
            axes[0][1].axhline(bound, color=GREY, linestyle="--", linewidth=0.8)
        near = axes[0][2]
        for level, results in runs.items():
            near.plot(
                start(results), curve(results).pressure, color=shades[level], linewidth=1.1, marker="o", markersize=2.5
            )
        near.axhline(0.0, color=GREY, linewidth=0.8)
        near.set(xlim=(0.55, 0.82), ylim=(-30, 130), xlabel="s from O [mm]", title="pressure at the edge of contact")

    picture("figure-15", 1, 3, fill, (12.0, 3.6))
    numbers: Numbers = {"dips": []}
    for algorithm in ALGORITHMS:
        for level in levels:
            found = curve(run(algorithm, "everywhere", level))
            p = np.asarray(found.pressure)
            dip = max(0.0, -p.min())
            inner = start(run(algorithm, "everywhere", level)) > 0.02  # the corner is singular
            numbers["dips"].append(
                f"| {SHORT[algorithm]} | {size(level):g} | {-dip if dip else 0.0:.1f} | "
                f"{percent(dip / p[inner].max())} | "
                f"{np.abs(np.asarray(found.shear)).max():.1f} |"
            )
    violation = max(
        run(algorithm, where, 4).summary["contacts"]["contacts.0"]["cone_violation"]
        for algorithm in ALGORITHMS[:2] for where in READINGS
    )  # fmt: skip
    numbers["violation"] = f"{violation:.1e}"
    return numbers


FIGURES = {"f13": figure_13, "f14": figure_14, "f15": figure_15}
