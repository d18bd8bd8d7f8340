"""All else of a single run: forces, contacts, energies, and times by phase."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.api.thinning import Thinning
from contactlab.jobs.rows import number
from contactlab.reports.numbers import percent, significant
from contactlab.reports.run import moment, vector
from contactlab.reports.sheet import Cell, Column, Sheet
from contactlab.reports.sheet import Line as Row
from contactlab.results.force_curve import THE_END_ONLY
from contactlab.results.results import Results
from contactlab.studies.measure_run import reaction_against_pressure
from contactlab.studies.measures import mirror_asymmetry
from contactlab.studies.profile import FoldedSurfaceError, Profile

Line = tuple[str, str, str]
"""Name, value, unit."""


def render_details(results: Results, scene: Mapping[str, Any], verbose: bool, profile: bool) -> RenderableType:
    """The tables that `--verbose` and `--profile` add."""
    groups: dict[str, list[Line]] = {}
    notes: list[str] = []
    if verbose:
        groups |= _groups(results, scene)
        if results.summary.get("history", {}).get("curve") == THE_END_ONLY:
            notes.append(
                "Loading path: dynamic, only the final state is in equilibrium. For a force-displacement curve set "
                "time.history = true."
            )
    if profile:
        cost = results.summary.get("cost", {})
        groups["cost"] = list(_cost_lines(cost))
        if apart := why_apart(number(cost.get("run_cpu_s")), number(cost.get("run_wall_s"))):
            notes.append(f"Wall time of the steps is {apart}.")
    return Group(_sheet({name: lines for name, lines in groups.items() if lines}), *map(Text, notes))


def _sheet(groups: Mapping[str, list[Line]]) -> Sheet:
    rows: list[Row] = []
    for title, lines in groups.items():
        rows.append(Row([Cell(title, kind="title"), "", ""]))
        rows += [Row([name, value, Cell(unit, kind="unit")], ends=n == len(lines))
                 for n, (name, value, unit) in enumerate(lines, start=1)]  # fmt: skip
    return Sheet([Column("", keep=True), Column("", number=True, keep=True), Column("", keep=True)], rows)


def _groups(results: Results, scene: Mapping[str, Any]) -> dict[str, list[Line]]:
    summary, units = results.summary, Units.of_label(scene.get("units"))
    titles = {contact.name: f"{contact.name}: {contact.title}" for contact in results.layout.contacts}
    contacts = {titles[name]: list(_contact_lines(name, results, scene, units)) for name in summary.get("contacts", {})}
    return {
        "run": list(_run_lines(summary, units)),
        "supports": list(_support_lines(summary, scene, units)),
        **contacts,
        "energy": list(_energy_lines(summary.get("balance", {}), units)),
    }


def _run_lines(summary: Mapping[str, Any], units: Units) -> Iterator[Line]:
    steps, sweeps = summary.get("steps", 0), summary.get("contact_sweeps", 0)
    yield "steps", f"{steps:,}".replace(",", " "), ""
    if sweeps:
        yield "Gauss-Seidel iterations per step", significant(sweeps / max(1, steps), 3), ""
    if summary.get("iterations"):
        yield "Newton iterations per step", significant(summary["iterations"] / max(1, steps), 3), ""
    for name, thinned in summary.get("thinned", {}).items():
        yield f"{name}, recorded", str(Thinning(**thinned)), ""
    for level in summary.get("nested", ()):
        yield f"level {level['level']} before", f"{level['iterations']} iterations", ""
    for key, value in summary.get("resolved", {}).items():
        if key == "integrator":  # the summary has its line
            continue
        unit = f"1/{units.time}" if key == "damping" else units.time
        yield f"time.{key}, chosen", significant(float(value), 4), unit


def _support_lines(summary: Mapping[str, Any], scene: Mapping[str, Any], units: Units) -> Iterator[Line]:
    reactions = summary.get("reactions", {})
    peaks = summary.get("peaks", {}).get("reactions", {})
    for on, force in reactions.items():
        yield f"reaction of {on}", vector(force), units.line_force
        if on in peaks:
            yield f"  peak, {moment(peaks[on], summary, units)}", vector(peaks[on]["vector"]), units.line_force
    mismatch = number(summary.get("reaction_mismatch"))
    if mismatch == mismatch:
        yield "force imbalance, relative", percent(mismatch), "%"
    vectors = {on: np.asarray(force, float) for on, force in reactions.items()}
    for name, contact in summary.get("contacts", {}).items():
        index, integral = int(name.rpartition(".")[2]), np.asarray(contact["pressure_integral"], float)
        share = reaction_against_pressure(scene, vectors, index, integral)
        if share == share:
            yield f"reaction vs pressure of {name}", percent(share), "%"


def _contact_lines(name: str, results: Results, scene: Mapping[str, Any], units: Units) -> Iterator[Line]:
    contact = results.summary["contacts"][name]
    yield "force on the slave", vector(contact["resultant"]), units.line_force
    yield "integral of its pressure", vector(contact["pressure_integral"]), units.line_force
    yield "max pressure", significant(number(contact["max_pressure"]), 5), units.pressure
    side = contact.get("penetrating_side")
    yield "max penetration" + (f", by the {side}" if side else ""), _short(contact["max_penetration"]), units.length
    if "cone_violation" in contact:
        yield "residual of the contact conditions", _short(abs(contact["cone_violation"])), ""
    if contact.get("stiffness"):
        least, most = (significant(number(value), 3) for value in contact["stiffness"])
        yield "active-set parameter c", f"{least} to {most}", f"{units.line_force}/{units.length}"
    if scene.get("symmetry") == "x":
        try:
            asymmetry = mirror_asymmetry(Profile.of_curve(results.contact[name].last))
        except (FoldedSurfaceError, LookupError):
            asymmetry = float("nan")
        yield "mirror asymmetry of the pressure", percent(asymmetry), "%"


def _energy_lines(balance: Mapping[str, Any], units: Units) -> Iterator[Line]:
    names = {"kinetic": "kinetic", "stored": "stored", "internal": "work of stresses", "external": "work of supports"}
    names |= {"damping": "lost to damping", "friction": "lost to friction", "plastic": "lost to plastic flow"}
    for key, name in names.items():
        # no work is known where the way was not followed
        if balance.get(key) or (key in ("kinetic", "stored", "internal", "external") and balance.get(key) is not None):
            yield name, significant(number(balance.get(key)), 5), units.line_energy
    kinetic, internal = number(balance.get("kinetic")), abs(number(balance.get("internal")))
    if internal > 0.0:
        yield "kinetic / work of stresses", _short(kinetic / internal), ""
    if balance.get("ledger_error") is not None:
        yield "error of the energy balance", _short(balance["ledger_error"]), ""
    if balance.get("stored_against_work") is not None:
        yield "stored energy against work, relative", _short(balance["stored_against_work"]), ""


def _cost_lines(cost: Mapping[str, Any]) -> Iterator[Line]:
    total, wall = number(cost.get("run_cpu_s")), number(cost.get("run_wall_s"))
    yield "CPU time of the steps", significant(total, 3), "s"
    if wall == wall:
        yield "wall time of the steps", significant(wall, 3), "s"
    phases = cost.get("phases", {})
    whole = sum(phases.values())
    for name, seconds in phases.items():
        if whole > 0.0:
            yield f"  {name}", percent(seconds / whole), "%"
            for what, parts in cost.get("parts", {}).get(name, {}).items():
                for part, time in parts.items():
                    yield f"    {what}{part_label(part)}", percent(time / whole), "%"
    for key, name in (("compile_s", "  compiling and loading kernels"), ("build_s", "building the model")):
        if key in cost:
            yield name, significant(number(cost[key]), 2), "s"
    if "peak_memory_mib" in cost:
        yield "peak memory", significant(number(cost["peak_memory_mib"]), 3), "MiB"


APART = 2.0
"""Ratio of wall and CPU time above which a note is printed."""


def why_apart(cpu: float, wall: float) -> str:
    """Why wall and CPU times differ by more than a factor of `APART`; empty if they do not."""
    if wall > APART * cpu:
        return f"{wall / max(cpu, 1e-9):.1f} times the CPU time: other processes ran on the machine, or files were slow"
    if cpu > APART * wall:
        return f"1/{cpu / max(wall, 1e-9):.1f} of the CPU time: several threads ran"
    return ""


def part_label(part: str) -> str:
    """A part of a phase, with its distribution if that is not the project's own."""
    name, _, package = part.partition(" (")
    if name == "contactlab":
        return ""
    return f": {name}" if not package or package.startswith("contactlab") else f": {part}"


def _short(value: object) -> str:
    return significant(number(value), 2)
