"""Contact pressures of many runs as one map: a line of colours per run, the reference below them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from contactlab.api.drawing.colours import FIELD
from contactlab.api.drawing.units import Units
from contactlab.reports.figures import ALARM, MUTED, house_style, note
from contactlab.reports.series import series_of
from contactlab.studies.profile import Profile
from contactlab.studies.table import Row, Table

PANELS = 12
"""Plots that are drawn beside each other; more runs than that become a map."""
_POINTS = 400
FAR_ABOVE = 4.0  # times the median: peaks of chatter, which would leave all else dark


def pressure_map(table: Table) -> Figure:
    """Position to the right, runs downwards, pressure as colour; a run without a pressure says how it ended."""
    rows = table.main
    units = Units.of_label(table.scene.get("units"))
    known: list[tuple[str, Profile | None, Row | None]] = [(_label(row, rows), row.profile, row) for row in rows]
    if table.reference is not None:
        known.append(("reference", table.reference.profile, None))
    profiles = [profile for _, profile, _ in known if profile is not None]
    with house_style():
        figure = Figure(figsize=(9.5, 1.2 + 0.19 * len(known)), layout="constrained")
        axes = figure.subplots()
        axes.grid(False)
        if not profiles:
            note(axes, "no run left a pressure")
            return figure
        left, right, top = _range(profiles)
        at = np.linspace(left, right, _POINTS)
        values = [np.full(_POINTS, np.nan) if profile is None else profile(at) for _, profile, _ in known]
        drawn = axes.imshow(
            np.array(values), aspect="auto", cmap=LinearSegmentedColormap.from_list("field", FIELD), vmin=0.0, vmax=top,
            extent=(left, right, len(known) - 0.5, -0.5), interpolation="nearest",
        )  # fmt: skip
        axes.set_yticks(range(len(known)), [label for label, _, _ in known], fontsize=7.5)
        for number, (_, profile, row) in enumerate(known):
            if row is not None and (profile is None or not row.finished):
                axes.text(right, number, f" {row.status}", va="center", ha="left", fontsize=7.0, color=ALARM)
        axes.set_xlabel(f"deformed position x{_in(units.length)}")
        above = any(profile.value.max() > top for profile in profiles)
        bar = figure.colorbar(drawn, ax=axes, pad=0.09, extend="max" if above else "neither")
        bar.set_label(f"pressure{_in(units.pressure)}", color=MUTED)
    return figure


def _label(row: Row, rows: Sequence[Row]) -> str:
    level = f", level {row.level}" if len({each.level for each in rows}) > 1 else ""
    slave = f", {row.slave}" if len({each.slave for each in rows}) > 1 else ""
    return f"{series_of(row, rows)}{slave}{level}"


def _range(profiles: Sequence[Profile]) -> tuple[float, float, float]:
    """Where anything presses, and the largest pressure, or one that most runs stay below where peaks are far above."""
    pressed = [p.x[p.value > 0.01 * p.value.max()] for p in profiles if np.any(p.value > 0.0)]
    if not pressed:
        return float(profiles[0].x[0]), float(profiles[0].x[-1]), 1.0
    left, right = min(x[0] for x in pressed), max(x[-1] for x in pressed)
    tops: Any = [p.value.max() for p in profiles]
    margin = 0.1 * (right - left)
    usual, largest = float(np.median(tops)), float(max(tops))
    return float(left - margin), float(right + margin), largest if largest <= FAR_ABOVE * usual else 1.15 * usual


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""
