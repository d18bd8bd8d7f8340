"""Short report of a single run: status, peak pressure and force, steps, warnings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from contactlab.api.drawing.units import Units
from contactlab.jobs.rows import number
from contactlab.reports.numbers import significant
from contactlab.reports.sheet import STYLES
from contactlab.reports.terminal import Terminal
from contactlab.results.peaks import final_force, peak_force, peak_pressure
from contactlab.results.results import Results
from contactlab.results.shown_pressure import other_peak
from contactlab.run.attempts import Attempt
from contactlab.studies.measure_run import driven_support

MOST = 3
"""Contacts that are listed; if there are more, only the contact with the highest pressure."""

THE_END = "at the end"
SMALL_PART = 1e-4
"""Part of the work below which no number is shown."""
CLEARLY = 0.999
"""Ratio of two values below which both are shown."""


def print_run(
    results: Results,
    scene: Mapping[str, Any],
    console: Console | None = None,
    verbose: bool = False,
    profile: bool = False,
) -> None:
    """Print the summary of a run; `scene` is its TOML data with defaults.

    verbose  adds forces, contacts and energies; profile times by phase
    """
    console = console or Terminal()
    console.print(render_run(results, scene))
    if verbose or profile:
        from contactlab.reports.run_details import render_details

        console.print(render_details(results, scene, verbose, profile))
    if results.folder is not None:
        console.print(f"results in {results.folder}", markup=False, highlight=False, soft_wrap=True)


def render_run(results: Results, scene: Mapping[str, Any]) -> RenderableType:
    """Status and reason, five lines of numbers, and the text of each warning."""
    summary = results.summary
    status = Text.assemble(
        (str(summary.get("scene", "")), "bold"), ": ", (results.status, f"bold {STYLES.get(results.status, 'red')}")
    )
    reason = [Text(results.reason)] if results.reason else []
    lines = Table.grid(padding=(0, 2))
    lines.add_column(style="bold", no_wrap=True)
    lines.add_column()
    for name, text in _lines(results, scene):
        lines.add_row(Text(name), Text(text))
    return Group(
        status,
        *reason,
        lines,
        *[Text.assemble((f"warning ({warning.code}): ", "bold yellow"), warning.text) for warning in results.warnings],
    )


def _lines(results: Results, scene: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    units = Units.of_label(scene.get("units"))
    yield from _named("peak pressure", _pressures(results, units))
    yield from _named("peak force", _force(results, scene, units))
    if chosen := results.summary.get("resolved", {}).get("integrator"):
        yield "integrator", integrator(chosen)
    yield "steps", _steps(results.summary)
    if took := results.summary.get("stabilisation"):
        steps = "1 step" if took["steps"] == 1 else f"{took['steps']:.0f} steps"
        part = f"{took['share']:.2%}" if abs(took["share"]) >= SMALL_PART else f"less than {SMALL_PART:.2%}"
        yield "stabilised", f"{steps}; stabilisation took {part} of the work"
    codes = list(dict.fromkeys(warning.code for warning in results.warnings))
    yield "warnings", f"{len(codes)}: {', '.join(codes)}" if codes else "none"


def integrator(chosen: Mapping[str, Any]) -> str:
    """The integrator that was taken, and each that came short, in one line."""
    tried = [Attempt(**attempt).brief for attempt in chosen["tried"]]
    return "; ".join([chosen["use"], *tried])


def _named(name: str, texts: Sequence[str]) -> Iterator[tuple[str, str]]:
    for place, text in enumerate(texts):
        yield name if place == 0 else "", text


def _pressures(results: Results, units: Units) -> list[str]:
    summary, titles = results.summary, {contact.name: contact.title for contact in results.layout.contacts}
    peaks = {name: peak for name in titles if (peak := peak_pressure(summary, name)) is not None}
    highest = sorted(peaks, key=lambda name: -peaks[name]["value"])
    more = f" (highest of {len(peaks)} contacts)" if len(peaks) > MOST else ""
    texts = []
    for name in peaks if not more else highest[:1]:
        peak, end = peaks[name], number(summary["contacts"].get(name, {}).get("max_pressure"))
        when = moment(peak, summary, units)
        text = f"{_with_unit(peak['value'], units.pressure)}, {titles[name]}, {when}"
        if when != THE_END and end < CLEARLY * peak["value"]:
            text += f"; {THE_END} {_with_unit(end, units.pressure)}"
        if (nodal := other_peak(summary["contacts"].get(name, {}))) is not None:
            text += f"; {_with_unit(nodal, units.pressure)} as force over length {THE_END}"
        texts.append(text + more)
    return texts


def _force(results: Results, scene: Mapping[str, Any], units: Units) -> list[str]:
    """The largest force of the driven support; without supports, of the first contact."""
    summary = results.summary
    reactions = {on: np.asarray(force, float) for on, force in summary.get("reactions", {}).items()}
    on = driven_support(scene, reactions) or next(iter(summary.get("contacts", {})), "")
    peak, end = peak_force(summary, on), final_force(summary, on)
    if peak is None or end is None:
        return []
    text = f"{_with_unit(peak['value'], units.line_force)}, {on}, {moment(peak, summary, units)}"
    return [f"{text}{'' if text.endswith(THE_END) else f'; {THE_END}'} ({vector(end, ', ')})"]


def moment(peak: Mapping[str, Any], summary: Mapping[str, Any], units: Units) -> str:
    """When something was: at the end, at a share of the load (statics), or at a time."""
    if peak["step"] == summary.get("steps"):
        return THE_END
    if summary.get("reached", {}).get("of") == "load":
        return f"at {100.0 * peak['share']:.0f} % of the load"
    return f"at t = {_with_unit(peak['time'], units.time, 3)}"


def _steps(summary: Mapping[str, Any]) -> str:
    cost, steps = summary.get("cost", {}), summary.get("steps", 0)
    text = f"{steps:,}".replace(",", " ")
    if summary.get("iterations"):
        text += f", {significant(summary['iterations'] / max(1, steps), 2)} iterations each,"
    wall, compiling = number(cost.get("run_wall_s")), number(cost.get("compile_s"))
    if wall == wall:
        text += f" in {significant(wall, 3)} s"
        if compiling > 0.2 * wall:
            text += f", {significant(compiling, 2)} s of it to compile or load kernels"
    return text


def _with_unit(value: object, unit: str, digits: int = 5) -> str:
    return f"{significant(number(value), digits)} {unit}".rstrip()


def vector(force: Sequence[float], between: str = "  ", digits: int = 5) -> str:
    """Components with so many digits; what is below 1e-7 of the largest is round-off and shown as 0."""
    values = [float(component) for component in force]
    largest = max(map(abs, values), default=0.0)
    return between.join(significant(v if abs(v) > 1e-7 * largest else 0.0, digits) for v in values)
