"""Test 3 of the paper, forging of three bodies: figure 16."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
from common import COLOURS, GREY, PICTURES, SHORT, Numbers, area, percent
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

import contactlab
from contactlab.api import Frame
from contactlab.api.drawing.colours import FIELD
from contactlab.reports.figures import ALARM, house_style
from contactlab.results.results import Results

BODIES = ("anvil", "billet", "punch")
SEGMENT, ARC = 1.0, 0.0125  # mm: of the slaves, and rise of the billet's arc over it
RADIUS = 10.0  # mm, of the billet's nose
FRAMES = 200
NEARER = {1.25: ([56, 11], [40, 8]), 1.0: ([70, 14], [50, 10])}  # ratio of segments: cells of anvil and punch


def forge(algorithm: str, *, fine: bool = False, ratio: float = 1.75, level: int = 1) -> Results:
    """A run with its frames; `fine`: the billet is slave; `ratio` of the tools' segments to the billet's."""
    changes: dict[str, Any] = {f"contacts.{number}.algorithm": algorithm for number in range(3)}
    if fine:
        changes |= {"contacts.0.swap": True, "contacts.1.swap": True}
    if ratio in NEARER:
        changes |= {
            f"bodies.{body}.mesh.cells": cells for body, cells in zip(("anvil", "punch"), NEARER[ratio], strict=True)
        }
    changes["level"] = level
    folder = Path(mkdtemp()) / "run"
    scene = contactlab.load_scene("three-body-forging").with_(
        changes | {"record.frames": FRAMES, "record.recorders": ["vtkhdf"]}
    )
    return contactlab.simulate(scene, out=folder)


def sound(frames: Sequence[Frame]) -> list[Frame]:
    """Frames before numbers mean nothing."""
    return [frame for frame in frames if np.isfinite(frame.displacement).all() and np.abs(frame.displacement).max() < 5]


def depth(frame: Frame) -> float:
    """How far the punch is down [mm]."""
    return -frame.scalars["punch.top.uy"]


def at(frames: list[Frame], wanted: float) -> Frame:
    """The frame nearest to a depth."""
    return min(frames, key=lambda frame: abs(depth(frame) - wanted))


def draw(axes: Any, results: Results, frame: Frame, window: tuple[float, float, float, float]) -> Any:
    """Bodies in their deformed shape, coloured by plastic strain."""
    x = results.nodes + frame.displacement
    colours = LinearSegmentedColormap.from_list("field", FIELD)
    for body in BODIES:
        cells = results.cells[body]
        strain = frame.cells[body]["equivalent_plastic_strain"]
        shapes = PolyCollection(x[cells], array=strain, cmap=colours, edgecolors="#ffffff", linewidths=0.25)
        shapes.set_clim(0.0, 0.4)
        axes.add_collection(shapes)
    axes.axhline(0.0, color=GREY, linewidth=1.5)
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal", xticks=[], yticks=[])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return shapes


def figure_16() -> Numbers:
    """A strip of frames, nodes on segments above, mortar P0 below; penetration over the way of the punch."""
    runs = {algorithm: forge(algorithm) for algorithm in ("node-on-segment", "mortar-p0", "mortar-p1")}
    fine = {algorithm: forge(algorithm, fine=True) for algorithm in ("node-on-segment", "mortar-p0")}
    frames = {algorithm: sound(results.frames) for algorithm, results in runs.items()}
    _strip(runs, frames)
    finer = forge("mortar-p0", level=4)
    curves = {
        "P0, tools are slaves": forces(frames["mortar-p0"]), "P0, billet is slave": forces(fine["mortar-p0"].frames),
        "P0, tools, cells a quarter as long": forces(finer.frames),
    }  # fmt: skip
    _curves(frames, {name: sound(results.frames) for name, results in fine.items()}, curves)
    numbers = _numbers(runs, frames, fine) | {"ratios": _ratios()}
    way = np.linspace(0.2, 2.5, 231)
    tools, billet, reference = (np.interp(way, *curve) for curve in curves.values())
    numbers["finer"] = f"{reference[-1]:.0f}"
    numbers["finer_tools"] = percent(float(np.abs(tools - reference).max() / reference.max()))
    numbers["finer_billet"] = percent(float(np.abs(billet - reference).max() / reference.max()))
    numbers["finer_end"] = percent(abs(tools[-1] / reference[-1] - 1.0))
    numbers["finer_end_billet"] = percent(abs(billet[-1] / reference[-1] - 1.0))
    for results in (*runs.values(), *fine.values(), finer):
        shutil.rmtree(results.folder.parent)  # type: ignore[union-attr]
    return numbers


def forces(frames: Sequence[Frame]) -> tuple[Any, Any]:
    """Way of the punch [mm] and force on the floor [N/mm] of every frame, until the punch is down."""
    way = np.array([depth(frame) for frame in frames])
    force = np.array([frame.scalars["floor.fy"] for frame in frames])
    first = int(np.argmax(way > way.max() - 1e-9)) + 1
    way, force = way[:first], np.abs(force[:first])
    # its last value is that of the run's end, when vibrations have died
    force[-1] = abs(frames[-1].scalars["floor.fy"])
    return way, force


def _ratios() -> list[str]:
    """Penetration with tool segments nearer to the billet's: largest over the run, beside the limit."""
    rows = []
    for ratio, algorithm in product(NEARER, ("node-on-segment", "mortar-p0", "mortar-p1")):
        results = forge(algorithm, ratio=ratio)
        segment = 40.0 / NEARER[ratio][0][0]
        deepest = max(frame.scalars["contacts.0.max_penetration"] for frame in sound(results.frames)) / segment
        force = abs(results.summary["reactions"]["floor"][1])
        rows.append(
            f"| {ratio:g} | {SHORT[algorithm]} | {results.status} | {force:.0f} | {percent(deepest)} | "
            f"{percent(0.02 + segment / (8.0 * RADIUS))} |"
        )
        shutil.rmtree(results.folder.parent)  # type: ignore[union-attr]
    return rows


def _strip(runs: dict[str, Results], frames: dict[str, list[Frame]]) -> None:
    ends = depth(frames["node-on-segment"][-1])
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
            frame = at(frames["node-on-segment"], stop)
            shapes = draw(place, runs["node-on-segment"], frame, near)
            place.set_title(f"node on segment, {depth(frame):.2f} mm", fontsize=9)
        for place, stop in zip(axes[1], stops, strict=True):
            frame = at(frames["mortar-p0"], stop)
            shapes = draw(place, runs["mortar-p0"], frame, near if stop <= ends else whole)
            place.set_title(f"mortar P0, {depth(frame):.2f} mm", fontsize=9)
        figure.colorbar(shapes, ax=axes, label="equivalent plastic strain", shrink=0.6)
        PICTURES.mkdir(parents=True, exist_ok=True)
        figure.savefig(PICTURES / "figure-16.png", dpi=92)


def _curves(frames: dict[str, list[Frame]], fine: dict[str, list[Frame]], curves: dict[str, tuple[Any, Any]]) -> None:
    with house_style():
        figure = Figure(figsize=(10.4, 3.5), layout="constrained")
        axes, right = figure.subplots(1, 2)
        for (label, (way, force)), colour in zip(curves.items(), (COLOURS["mortar-p0"], "#D55E00", GREY), strict=True):
            right.plot(way, force, color=colour, label=label, linewidth=1.2)
        right.set(xlabel="way of the punch [mm]", ylabel="force on the floor [N/mm]", title="force")
        right.legend(fontsize=7.5)
        for marker, (group, slaves) in zip(("-", ":"), ((frames, "tools"), (fine, "billet")), strict=True):
            for algorithm, found in group.items():
                deep = [max(frame.scalars["contacts.0.max_penetration"], 1e-5) / SEGMENT for frame in found]
                axes.semilogy(
                    [depth(frame) for frame in found], deep, marker, color=COLOURS[algorithm], linewidth=1.2,
                    label=f"{SHORT[algorithm]}, {slaves} are slaves" if slaves == "tools"
                    else f"{SHORT[algorithm]}, {slaves} is slave",
                )  # fmt: skip
        axes.axhline(0.02 + ARC, color=GREY, linestyle="--", linewidth=0.9)
        axes.set(xlabel="way of the punch [mm]", ylabel="penetration / segment", title="billet and anvil")
        axes.set_ylim(5e-5, 2.0)
        axes.legend(fontsize=7.5)
        figure.savefig(PICTURES / "figure-16-penetration.svg", metadata={"Date": None})


def _numbers(runs: dict[str, Results], frames: dict[str, list[Frame]], fine: dict[str, Results]) -> Numbers:
    broken = runs["node-on-segment"]
    numbers: Numbers = {
        "status": broken.status, "reason": broken.reason.split(";")[0], "rows": [],
        "depth": f"{depth(frames['node-on-segment'][-1]):.2f}", "kept": len(frames["node-on-segment"]),
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
        highest = max(frame.scalars["contacts.0.max_penetration"] for frame in frames[name]) / SEGMENT
        numbers[f"highest_{name[-2:]}"] = percent(highest)
    other = abs(fine["mortar-p0"].summary["reactions"]["floor"][1])
    numbers["swap"] = percent(abs(mortars[0] - other) / mortars[0])
    return numbers


FIGURES = {"f16": figure_16}
