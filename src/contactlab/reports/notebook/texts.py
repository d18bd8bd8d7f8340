"""Scenes, runs, comparisons and matrices in a few lines of text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contactlab.api.drawing.units import Units
from contactlab.cases.verdict import WORST
from contactlab.explanation.explain import Explanation
from contactlab.reports.numbers import significant
from contactlab.reports.run import vector
from contactlab.reports.sheet import Sheet
from contactlab.results.results import Results
from contactlab.results.shown_pressure import other_peak
from contactlab.scene.scene import Scene
from contactlab.studies.table import Table
from contactlab.verdicts.run import Matrix

MOST = 20
"""Lines of a text."""


def scene_text(scene: Scene) -> str:
    """Summary of a scene, a line per table."""
    return _lines(f"Scene {scene.name}", scene_facts(scene))


def scene_facts(scene: Scene) -> dict[str, str]:
    """The same by name."""
    bodies = [f"{name} ({body.element['use']}, {body.material}, {body.mesh['use']})"
              for name, body in scene.bodies.items()]  # fmt: skip
    contacts = [
        f"{' on '.join(c.sides)} ({c.algorithm['use']}" + (f", {c.friction['use']})" if c.friction else ")")
        for c in scene.contacts
    ]
    facts = {
        "source": scene.source,
        "level": str(scene.level),
        "integrator": str(scene.integrator["use"]),
        "time.end": str(scene.time.end),
        "materials": _some([f"{name} ({spec['use']})" for name, spec in scene.materials.items()]),
        "bodies": _some(bodies),
        "rigid": _some(list(scene.rigid)),
        "contacts": _some(contacts),
        "supports": _some([support.on for support in scene.supports]),
        "loads": _some([load.on for load in scene.loads]),
        "effects": _some([str(spec["use"]) for spec in scene.effects]),
    }
    return {name: value for name, value in facts.items() if value}


def results_text(results: Results) -> str:
    """Status of a run, and its main numbers."""
    return _lines(f"Results of {results.layout.title}: {results.status}", results_facts(results))


def results_facts(results: Results) -> dict[str, str]:
    """The same by name."""
    summary, units = results.summary, Units.of_label(results.layout.units)
    frames = len(results.history.get("time", ()))
    fields = f"{frames} frames stored" if results.frames else f"{frames} rows of history, fields of the end alone"
    facts = {"reason": results.reason, "steps": f"{summary.get('steps', 0)}, {fields}"}
    titles = {contact.name: contact.title for contact in results.layout.contacts}
    for name, contact in list(summary.get("contacts", {}).items())[:4]:
        facts[titles.get(name, name)] = _contact(contact, units)
    for on, force in list(summary.get("reactions", {}).items())[:4]:
        facts[f"reaction of {on}"] = f"{_pair(force)} {units.line_force}".rstrip()
    cost = summary.get("cost", {})
    if "run_cpu_s" in cost:
        facts["CPU time"] = f"{significant(float(cost['run_cpu_s']), 3)} s"
    facts["warnings"] = _some(list(dict.fromkeys(warning.code for warning in results.warnings)))
    facts["folder"] = str(results.folder or "")
    return {name: value for name, value in facts.items() if value}


def _contact(contact: Mapping[str, Any], units: Units) -> str:
    pressure = f"pressure up to {significant(float(contact['max_pressure']), 4)} {units.pressure}".rstrip()
    if (nodal := other_peak(contact)) is not None:
        pressure += f" ({significant(nodal, 4)} as force over length)"
    return f"{pressure}, force {_pair(contact['resultant'])} {units.line_force}".rstrip()


def _pair(force: Any) -> str:
    return f"[{vector(force, ', ', 4)}]"


def table_text(table: Table) -> str:
    """A line per run: how it ended, its error and its cost."""
    from contactlab.reports.table import runs_sheet

    sheet = runs_sheet(table, ("pressure_error", "cpu_s"))
    sheet.title = f"Table of {len(table)} runs: {table.study.name}"
    return sheet.text(MOST)


def matrix_text(matrix: Matrix) -> str:
    """Number of cells by verdict, and the worst cells."""
    counts = ", ".join(f"{matrix.count(verdict)} {verdict}" for verdict in WORST if matrix.count(verdict))
    heads = ("case", "variant", "contact", "slave", "verdict")
    cells = matrix.worst_first
    rows = ([*(cell.choices[name] for name in heads[:4]), result.verdict] for cell, result in cells)
    return Sheet(heads, rows, f"Matrix of {len(matrix.cells)} cells: {counts}").text(MOST)


def explanation_text(explanation: Explanation) -> str:
    """Size, effects and cost of a scene, and the names of the other tables."""
    about, price = explanation.scene, explanation.price
    facts = {
        "size": f"{about.cells} cells, {about.nodes} nodes, {about.contact_multipliers} multipliers",
        "integrator": about.integrator,
        "steps": f"about {about.estimated_steps}",
        "history": about.history,
        "effects": ", ".join(each.effect for each in explanation.effects if each.called_for),
        "not declared": ", ".join(each.effect for each in explanation.effects if not each.called_for),
    }
    if price is not None:
        cost = f"{significant(price.cpu_s, 2)} s of CPU time, and {significant(price.start_s, 2)} s to start"
        facts["cost"] = f"its trial ended {price.reason}" if price.reason else cost
    facts["tables"] = ", ".join(vars(explanation))
    return _lines(f"Explanation of {about.name}", {name: value for name, value in facts.items() if value})


def _lines(title: str, facts: Mapping[str, str]) -> str:
    width = max(map(len, facts), default=0)
    return "\n".join([title, *(f"  {name.ljust(width)}  {_short(value)}" for name, value in facts.items())][:MOST])


def _short(text: str, most: int = 200) -> str:
    line = " ".join(text.split())
    return line if len(line) <= most else line[: most - 3] + "..."


def _some(names: list[str], most: int = 6) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
