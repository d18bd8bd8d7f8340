"""Test 3 of the paper, forging of three bodies: figure 16."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from common import COLOURS, GREY, PICTURES, SHORT, Numbers, area, percent, run
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

import contactlab
from contactlab.api import Frame, Record
from contactlab.api.drawing.colours import FIELD
from contactlab.reports.figures import ALARM, house_style
from contactlab.results.results import Results

BODIES = ("anvil", "billet", "punch")
SEGMENT, ARC = 1.0, 0.0125  # mm: of the slaves, and rise of the billet's arc over it
RADIUS = 10.0  # mm, of the billet's nose
FRAMES, FAR = 200, 5.0  # of a run; mm, displacement from which numbers mean nothing
NEARER = {1.25: ([56, 11], [40, 8]), 1.0: ([70, 14], [50, 10])}  # ratio of segments: cells of anvil and punch


def forge(
    algorithm: str, *, fine: bool = False, ratio: float = 1.75, level: int = 1, drawn: bool = False
) -> Record:  # fmt: skip
    """A run; `fine`: the billet is slave; `ratio` of the tools' segments to the billet's; `drawn`: with its shapes."""
    changes: dict[str, Any] = {f"contacts.{number}.algorithm": algorithm for number in range(3)}
    if fine:
        changes |= {"contacts.0.swap": True, "contacts.1.swap": True}
    if ratio in NEARER:
        changes |= {
            f"bodies.{body}.mesh.cells": cells for body, cells in zip(("anvil", "punch"), NEARER[ratio], strict=True)
        }
    changes["level"] = level
    scene = contactlab.load_scene("three-body-forging").with_(changes | {"record.frames": FRAMES})
    return run(scene, shapes if drawn else sound)


def _sound(results: Results) -> list[Frame]:
    return [f for f in results.frames if np.isfinite(f.displacement).all() and np.abs(f.displacement).max() < FAR]


def sound(results: Results) -> dict[str, Any]:
    """How many frames there are before numbers mean nothing."""
    return {"frames": np.array([len(_sound(results))])}


def shapes(results: Results) -> dict[str, Any]:
    """These frames: displacements (f, N, 2) and plastic strains (f, n) of each body."""
    frames = _sound(results)
    strains = {body: np.array([f.cells[body]["equivalent_plastic_strain"] for f in frames]) for body in BODIES}
    return {"frames": np.array([len(frames)]), "displacement": np.array([f.displacement for f in frames]), **strains}


def history(record: Record, column: str) -> Any:
    """A column over the stored frames, before numbers mean nothing."""
    (kept,) = record.watched.values()
    return np.asarray(record.history[column])[: int(kept["frames"][0])]


def depth(record: Record) -> Any:
    """How far the punch is down [mm] at the stored frames."""
    return -history(record, "punch.top.uy")


def draw(axes: Any, record: Record, frame: int, window: tuple[float, float, float, float]) -> Any:
    """Bodies in their deformed shape, coloured by plastic strain."""
    drawn = record.watched["shapes"]
    x = record.nodes + drawn["displacement"][frame]
    colours = LinearSegmentedColormap.from_list("field", FIELD)
    for body in BODIES:
        cells = record.cells[body]
        patches = PolyCollection(
            x[cells], array=drawn[body][frame], cmap=colours, edgecolors="#ffffff", linewidths=0.25
        )
        patches.set_clim(0.0, 0.4)
        axes.add_collection(patches)
    axes.axhline(0.0, color=GREY, linewidth=1.5)
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal", xticks=[], yticks=[])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return patches


def figure_16() -> Numbers:
    """A strip of frames, nodes on segments above, mortar P0 below; penetration over the way of the punch."""
    runs = {algorithm: forge(algorithm, drawn=True) for algorithm in ("node-on-segment", "mortar-p0", "mortar-p1")}
    fine = {algorithm: forge(algorithm, fine=True) for algorithm in ("node-on-segment", "mortar-p0")}
    _strip(runs)
    finer = forge("mortar-p0", level=4)
    curves = {
        "P0, tools are slaves": forces(runs["mortar-p0"]), "P0, billet is slave": forces(fine["mortar-p0"]),
        "P0, tools, cells a quarter as long": forces(finer),
    }  # fmt: skip
    _curves(runs, fine, curves)
    numbers = _numbers(runs, fine) | _ratios()
    way = np.linspace(0.2, 2.5, 231)
    tools, billet, reference = (np.interp(way, *curve) for curve in curves.values())
    numbers["finer"] = f"{reference[-1]:.0f}"
    numbers["finer_tools"] = percent(float(np.abs(tools - reference).max() / reference.max()))
    numbers["finer_billet"] = percent(float(np.abs(billet - reference).max() / reference.max()))
    numbers["finer_end"] = percent(abs(tools[-1] / reference[-1] - 1.0))
    numbers["finer_end_billet"] = percent(abs(billet[-1] / reference[-1] - 1.0))
    return numbers


def forces(record: Record) -> tuple[Any, Any]:
    """Way of the punch [mm] and force on the floor [N/mm] of every frame, until the punch is down."""
    way, every = depth(record), np.abs(history(record, "floor.fy"))
    first = int(np.argmax(way > way.max() - 1e-9)) + 1
    way, force = way[:first], every[:first].copy()
    # its last value is that of the run's end, when vibrations have died
    force[-1] = every[-1]
    return way, force


def _ratios() -> Numbers:
    """Penetration with tool segments nearer to the billet's: largest over the run, beside the limit."""
    rows = []
    over: dict[str, dict[float, float]] = {"node-on-segment": {}, "mortar-p0": {}, "mortar-p1": {}}
    for ratio, algorithm in product(NEARER, ("node-on-segment", "mortar-p0", "mortar-p1")):
        results = forge(algorithm, ratio=ratio)
        segment = 40.0 / NEARER[ratio][0][0]
        deepest = float(history(results, "contacts.0.max_penetration").max()) / segment
        force = abs(results.summary["reactions"]["floor"][1])
        rows.append(
            f"| {ratio:g} | {SHORT[algorithm]} | {results.status} | {force:.0f} | {percent(deepest)} | "
            f"{percent(0.02 + segment / (8.0 * RADIUS))} |"
        )
        over[algorithm][ratio] = deepest / (0.02 + segment / (8.0 * RADIUS))
    nodes, *mortars = (list(found.values()) for found in over.values())
    told = [f"{max(both):.1f} times the limit at {ratio:g}" for ratio, *both in zip(NEARER, *mortars, strict=True)]
    return {"ratios": rows, "mortars_over": ", ".join(told), "nodes_over": f"{min(nodes):.1f} to {max(nodes):.1f}"}


def _strip(runs: dict[str, Record]) -> None:
    depths = {algorithm: depth(record) for algorithm, record in runs.items()}
    ends = depths["node-on-segment"][-1]
    stops = (0.5 * ends, ends, 1.0, 2.5)
    whole, near = (-21.0, 21.0, -0.6, 24.6), (-7.0, 7.0, 4.0, 12.0)
    with house_style():
        figure = Figure(figsize=(10.0, 4.6), layout="constrained")
        axes = figure.subplots(2, 4)
        for place, stop in zip(axes[0], stops, strict=True):
            if stop > ends + 1e-12:
                place.axis("off")
                place.text(0.5, 0.5, "diverged", ha="center", color=ALARM, transform=place.transAxes)
                continue
            frame = int(np.abs(depths["node-on-segment"] - stop).argmin())
            patches = draw(place, runs["node-on-segment"], frame, near)
            place.set_title(f"node on segment, {depths['node-on-segment'][frame]:.2f} mm", fontsize=9)
        for place, stop in zip(axes[1], stops, strict=True):
            frame = int(np.abs(depths["mortar-p0"] - stop).argmin())
            patches = draw(place, runs["mortar-p0"], frame, near if stop <= ends else whole)
            place.set_title(f"mortar P0, {depths['mortar-p0'][frame]:.2f} mm", fontsize=9)
        figure.colorbar(patches, ax=axes, label="equivalent plastic strain", shrink=0.6)
        PICTURES.mkdir(parents=True, exist_ok=True)
        figure.savefig(PICTURES / "figure-16.png", dpi=92)


def _curves(runs: dict[str, Record], fine: dict[str, Record], curves: dict[str, tuple[Any, Any]]) -> None:
    with house_style():
        figure = Figure(figsize=(10.4, 3.5), layout="constrained")
        axes, right = figure.subplots(1, 2)
        for (label, (way, force)), colour in zip(curves.items(), (COLOURS["mortar-p0"], "#D55E00", GREY), strict=True):
            right.plot(way, force, color=colour, label=label, linewidth=1.2)
        right.set(xlabel="way of the punch [mm]", ylabel="force on the floor [N/mm]", title="force")
        right.legend(fontsize=7.5)
        for marker, (group, slaves) in zip(("-", ":"), ((runs, "tools"), (fine, "billet")), strict=True):
            for algorithm, found in group.items():
                deep = np.maximum(history(found, "contacts.0.max_penetration"), 1e-5) / SEGMENT
                axes.semilogy(
                    depth(found), deep, marker, color=COLOURS[algorithm], linewidth=1.2,
                    label=f"{SHORT[algorithm]}, {slaves} are slaves" if slaves == "tools"
                    else f"{SHORT[algorithm]}, {slaves} is slave",
                )  # fmt: skip
        axes.axhline(0.02 + ARC, color=GREY, linestyle="--", linewidth=0.9)
        axes.set(xlabel="way of the punch [mm]", ylabel="penetration / segment", title="billet and anvil")
        axes.set_ylim(5e-5, 2.0)
        axes.legend(fontsize=7.5)
        figure.savefig(PICTURES / "figure-16-penetration.svg", metadata={"Date": None})


def _numbers(runs: dict[str, Record], fine: dict[str, Record]) -> Numbers:
    broken = runs["node-on-segment"]
    numbers: Numbers = {
        "status": broken.status, "reason": broken.reason.split(";")[0], "rows": [],
        "depth": f"{depth(broken)[-1]:.2f}", "kept": len(depth(broken)),
        "steps": broken.summary["steps"],
    }  # fmt: skip
    named = [(name, "tools", results) for name, results in runs.items()]
    named += [(name, "billet", results) for name, results in fine.items()]
    for name, slaves, results in named:
        if results.status != "finished":
            numbers["rows"].append(
                f"| {SHORT[name]} | {slaves} | {results.status} after step {results.summary['steps']} | | | | | |"
            )
            continue
        top, floor = (abs(results.summary["reactions"][key][1]) for key in ("punch.top", "floor"))
        contacts = results.summary["contacts"]
        deepest = max(contact["max_penetration"] for contact in contacts.values()) / SEGMENT
        x = results.nodes + results.displacement
        areas = max(abs(area(x, results.cells[b]) / area(results.nodes, results.cells[b]) - 1.0) for b in BODIES)
        balance = results.summary["balance"]
        numbers["rows"].append(
            f"| {SHORT[name]} | {slaves} | {results.status} | {floor:.0f} | {percent(abs(top - floor) / floor)} | "
            f"{percent(deepest)} | {percent(areas)} | {balance['ledger_error']:.0e} |"
        )
    mortars = [abs(runs[name].summary["reactions"]["floor"][1]) for name in ("mortar-p0", "mortar-p1")]
    numbers["mortars"] = percent(abs(mortars[0] - mortars[1]) / mortars[0])
    for name in ("mortar-p0", "mortar-p1"):
        highest = float(history(runs[name], "contacts.0.max_penetration").max()) / SEGMENT
        numbers[f"highest_{name[-2:]}"] = percent(highest)
    other = abs(fine["mortar-p0"].summary["reactions"]["floor"][1])
    numbers["swap"] = percent(abs(mortars[0] - other) / mortars[0])
    return numbers


FIGURES = {"f16": figure_16}
