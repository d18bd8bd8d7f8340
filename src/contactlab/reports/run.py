"""The table of a single run: how it ended, forces, contact, energies, cost."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from rich import box
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.reports.numbers import percent, significant
from contactlab.results.results import Results
from contactlab.results.summary import THE_END_ONLY
from contactlab.studies.measure_run import reaction_against_pressure
from contactlab.studies.measures import mirror_asymmetry
from contactlab.studies.profile import FoldedSurfaceError, Profile

Line = tuple[str, str, str]
"""What, how much, in which unit."""

_STYLES = {"finished": "bold green", "not-converged": "bold yellow"}


def print_run(results: Results, scene: Mapping[str, Any], console: Console | None = None) -> None:
    """Print the table of a run; `scene` is its TOML data with defaults."""
    console = console or Console()
    console.print(render_run(results, scene))
    if results.folder is not None:
        console.print(f"results in {results.folder}", markup=False, highlight=False, soft_wrap=True)


def render_run(results: Results, scene: Mapping[str, Any]) -> RenderableType:
    """Status, reason, and the numbers that tell whether to trust the run."""
    summary = results.summary
    status = Text.assemble((str(summary.get("scene", "")), "bold"), ": ", (results.status, _style(results.status)))
    reason = [Text(results.reason)] if results.reason else []
    return Group(status, *reason, _draw(_groups(results, scene)), *_warnings(results))


def _warnings(results: Results) -> list[Text]:
    """What the run says against itself, with what to try."""
    return [Text.assemble((f"warning ({warning.code}): ", "bold yellow"), warning.text) for warning in results.warnings]


def _style(status: str) -> str:
    return _STYLES.get(status, "bold red")


def _draw(groups: Mapping[str, list[Line]]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_header=False, pad_edge=False)
    table.add_column(style="bold")
    table.add_column()
    table.add_column(justify="right")
    table.add_column(style="dim")
    for name, lines in groups.items():
        for number, line in enumerate(lines):
            last = number == len(lines) - 1
            table.add_row(Text(name if number == 0 else ""), *map(Text, line), end_section=last)
    return table


def _groups(results: Results, scene: Mapping[str, Any]) -> dict[str, list[Line]]:
    summary, units = results.summary, Units.of_label(scene.get("units"))
    groups = {
        "run": list(_run_lines(summary, units)),
        "supports": list(_support_lines(summary, scene, units)),
        **{name: list(_contact_lines(name, results, scene, units)) for name in summary.get("contacts", {})},
        "energy": list(_energy_lines(summary.get("balance", {}), units)),
        "cost": list(_cost_lines(summary.get("cost", {}))),
    }
    return {name: lines for name, lines in groups.items() if lines}


def _run_lines(summary: Mapping[str, Any], units: Units) -> Iterator[Line]:
    steps, sweeps = summary.get("steps", 0), summary.get("contact_sweeps", 0)
    yield "steps", f"{steps:,}".replace(",", " "), ""
    if summary.get("contacts"):
        yield "sweeps per step", significant(sweeps / max(1, steps), 3), ""
    if summary.get("iterations"):
        yield "iterations per step", significant(summary["iterations"] / max(1, steps), 3), ""
    if summary.get("history", {}).get("curve") == THE_END_ONLY:
        yield "the way to the end", "not in equilibrium: history.csv is no force-displacement curve", ""
    for level in summary.get("nested", ()):
        yield f"level {level['level']} before", f"{level['iterations']} iterations", ""
    for key, value in summary.get("resolved", {}).items():
        unit = f"1/{units.time}" if key == "damping" else units.time
        yield f"{key}, chosen", significant(float(value), 4), unit


def _support_lines(summary: Mapping[str, Any], scene: Mapping[str, Any], units: Units) -> Iterator[Line]:
    reactions = summary.get("reactions", {})
    for on, force in reactions.items():
        yield f"reaction of {on}", _vector(force), units.line_force
    mismatch = _float(summary.get("reaction_mismatch"))
    if mismatch == mismatch:
        yield "sum of reactions over the largest", percent(mismatch), "%"
    vectors = {on: np.asarray(force, float) for on, force in reactions.items()}
    for name, contact in summary.get("contacts", {}).items():
        number, integral = int(name.rpartition(".")[2]), np.asarray(contact["pressure_integral"], float)
        share = reaction_against_pressure(scene, vectors, number, integral)
        if share == share:
            yield f"reaction against pressure of {name}", percent(share), "%"


def _contact_lines(name: str, results: Results, scene: Mapping[str, Any], units: Units) -> Iterator[Line]:
    contact = results.summary["contacts"][name]
    yield "force on the slave", _vector(contact["resultant"]), units.line_force
    yield "integral of its pressure", _vector(contact["pressure_integral"]), units.line_force
    yield "largest pressure", significant(_float(contact["max_pressure"]), 5), units.pressure
    side = contact.get("penetrating_side")
    yield (
        "deepest penetration" + (f" (by the {side})" if side else ""),
        _short(contact["max_penetration"]),
        units.length,
    )
    if "cone_violation" in contact:
        yield "violation of the contact cone", _short(abs(contact["cone_violation"])), ""
    if contact.get("stiffness"):
        least, most = (significant(_float(value), 3) for value in contact["stiffness"])
        yield "stiffness that statuses are decided by", f"{least} to {most}", f"{units.line_force}/{units.length}"
    if scene.get("symmetry") == "x":
        yield "mirror asymmetry of the pressure", percent(_asymmetry(results, name)), "%"


def _asymmetry(results: Results, name: str) -> float:
    try:
        return mirror_asymmetry(Profile.of_curve(results.contact[name].last))
    except (FoldedSurfaceError, LookupError):
        return float("nan")


def _energy_lines(balance: Mapping[str, Any], units: Units) -> Iterator[Line]:
    names = {"kinetic": "kinetic", "stored": "stored", "internal": "work of stresses", "external": "work of supports"}
    names |= {"damping": "lost to damping", "friction": "lost to friction", "plastic": "lost to plastic flow"}
    for key, name in names.items():
        # no work is known where the way was not followed
        if balance.get(key) or (key in ("kinetic", "stored", "internal", "external") and balance.get(key) is not None):
            yield name, significant(_float(balance.get(key)), 5), units.line_energy
    kinetic, internal = _float(balance.get("kinetic")), abs(_float(balance.get("internal")))
    if internal > 0.0:
        yield "kinetic over work of stresses", _short(kinetic / internal), ""
    if balance.get("ledger_error") is not None:
        yield "energy error: ledger", _short(balance["ledger_error"]), ""
    if balance.get("stored_against_work") is not None:
        yield "energy error: stored against work", _short(balance["stored_against_work"]), ""


def _cost_lines(cost: Mapping[str, Any]) -> Iterator[Line]:
    total, wall = _float(cost.get("run_cpu_s")), _float(cost.get("run_wall_s"))
    yield "CPU time of the steps", significant(total, 3), "s"
    if wall == wall:
        yield f"wall time of the steps{why_apart(total, wall)}", significant(wall, 3), "s"
    phases = cost.get("phases", {})
    whole = sum(phases.values())
    for name, seconds in phases.items():
        if whole > 0.0:
            yield f"  of it {name}", percent(seconds / whole), "%"
            for what, parts in cost.get("parts", {}).get(name, {}).items():
                for part, time in parts.items():
                    yield f"    {what}{part_label(part)}", percent(time / whole), "%"
    for key, name in (("compile_s", "  of it compiling and loading kernels"), ("build_s", "building the model")):
        if key in cost:
            yield name, significant(_float(cost[key]), 2), "s"
    if "peak_memory_mib" in cost:
        yield "memory at most", significant(_float(cost["peak_memory_mib"]), 3), "MiB"


APART = 2.0
"""Ratio of wall and CPU time from which on a word is due."""


def why_apart(cpu: float, wall: float) -> str:
    """What may be behind wall and CPU times that differ much."""
    if wall > APART * cpu:
        return f" ({wall / max(cpu, 1e-9):.1f} times CPU: others were at work on the machine, or files were waited for)"
    if cpu > APART * wall:
        return f" (CPU is {cpu / max(wall, 1e-9):.1f} times that: several threads were at work)"
    return ""


def part_label(part: str) -> str:
    """A part of a phase; its distribution is told where it is not the project's own."""
    name, _, package = part.partition(" (")
    if name == "contactlab":
        return ""
    return f": {name}" if not package or package.startswith("contactlab") else f": {part}"


def _vector(force: Iterable[float]) -> str:
    """Components to five figures of the largest: what is smaller is round-off and shown as 0."""
    values = [float(component) for component in force]
    largest = max(map(abs, values), default=0.0)
    return "  ".join(significant(v if abs(v) > 1e-7 * largest else 0.0, 5) for v in values)


def _short(value: object) -> str:
    return significant(_float(value), 2)


def _float(value: Any) -> float:
    return float("nan") if value is None else float(value)
