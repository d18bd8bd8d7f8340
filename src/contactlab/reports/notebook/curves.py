"""Figures of contact curves and of force against displacement."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.api.arrays import Floats
from contactlab.api.drawing.colours import REFERENCE, STYLES, style_of
from contactlab.api.drawing.units import Units
from contactlab.api.frame import ContactCurve
from contactlab.reports.figures import FAINT, MUTED, house_style
from contactlab.reports.notebook.canvas import canvas, with_unit
from contactlab.results.force_curve import ForceCurve, force_curve
from contactlab.results.results import Results
from contactlab.results.shown_pressure import shown_pressure, shown_shear

DASHED = (0, (4, 1.5))
NOT_IN_EQUILIBRIUM = "dynamic: only the final state is in equilibrium (time.history = true gives a curve)"
TOO_FEW = "fewer than 3 states are stored (time.history = true, more integrator.steps or record.frames)"


def curve_figure(curve: ContactCurve, units: str = "", ax: Axes | None = None, title: str = "") -> Figure:
    """Pressure and shear along the slave, open nodes in grey, a line per chain."""
    names = Units.of_label(units)
    with house_style():
        figure, axes = canvas(ax, 3.2)
        for number in np.unique(curve.chain):
            here = curve.chain == number
            label = number == curve.chain.min()
            _line(axes, curve.s[here], shown_pressure(curve)[here], 0, "pressure" if label else "")
            if np.any(curve.shear != 0.0):
                _line(axes, curve.s[here], shown_shear(curve)[here], 1, "shear" if label else "")
        still = curve.state == 0
        if still.any():
            axes.plot(curve.s[still], shown_pressure(curve)[still], "o", color=REFERENCE, markersize=3.2, label="open")
        axes.axhline(0.0, color=FAINT, linewidth=0.8, zorder=0)
        axes.set_xlabel(with_unit("arc length of the slave", names.length))
        axes.set_ylabel(with_unit("traction", names.pressure))
        axes.set_title(title)
        axes.legend()
    return figure


def _line(axes: Axes, x: Floats, y: Floats, style: int, label: str) -> None:
    colour, marker = STYLES[style].colour, STYLES[style].marker
    axes.plot(x, y, color=colour, marker=marker, markersize=3, linewidth=1.3, label=label or None)


def pressure_figure(results: Results, contact: str = "", ax: Axes | None = None) -> Figure:
    """The last curves of all contacts below each other, or of one of them."""
    contacts = results.layout.contacts if not contact else [c for c in results.layout.contacts if contact in
                                                             (c.name, c.label)]  # fmt: skip
    curves = [(c.title, results.contact[c.name].last) for c in contacts]
    if len(curves) == 1:
        return curve_figure(curves[0][1], results.layout.units, ax, curves[0][0])
    with house_style():
        figure, first = canvas(ax, 2.6 * max(1, len(curves)))
        if ax is None and len(curves) > 1:
            first.remove()
            for axes, (title, curve) in zip(figure.subplots(len(curves), 1), curves, strict=True):
                curve_figure(curve, results.layout.units, axes, title)
        elif curves:
            for title, curve in curves:
                first.plot(curve.s, shown_pressure(curve), linewidth=1.3, label=title)
            names = Units.of_label(results.layout.units)
            first.set_xlabel(with_unit("arc length of the slave", names.length))
            first.set_ylabel(with_unit("pressure", names.pressure))
            first.legend()
    return figure


def force_figure(results: Results, on: str, component: str, ax: Axes | None) -> Figure:
    """The force of a support or contact against displacement, or against the share of the load."""
    names = {contact.label: contact.name for contact in results.layout.contacts}
    curve = force_curve(results.history, names.get(on, on), results.summary, component)
    algorithms = list(dict.fromkeys(contact.algorithm for contact in results.layout.contacts))
    colour = style_of(algorithms[0]).colour if algorithms else STYLES[0].colour
    with house_style():
        figure, axes = canvas(ax, 3.6)
        draw_force(axes, curve, colour, "", Units.of_label(results.layout.units))
        if ax is None:
            axes.set_title(results.layout.title)
            remark(axes, [curve])
    return figure


def draw_force(axes: Axes, curve: ForceCurve, colour: str, label: str, units: Units, style: Any = None) -> None:
    """Draw a curve with a mark at its largest force; thin if its states are not in equilibrium."""
    style = style or ("-" if curve.equilibrium else DASHED)
    width = 1.5 if curve.equilibrium else 0.8
    axes.plot(curve.x, curve.force, color=colour, linewidth=width, linestyle=style, label=label or None)
    if len(curve.x) and curve.equilibrium:
        k = int(np.argmax(np.abs(curve.force)))
        axes.plot(curve.x[k], curve.force[k], "o", color=colour, markersize=4)
    x, y = curve.labels(units)
    axes.set_xlabel(x)
    axes.set_ylabel(y)


def remark(axes: Axes, curves: list[ForceCurve]) -> None:
    """Say why these are no curves of equilibria, if they are not."""
    text = TOO_FEW if all(len(curve.x) < 3 for curve in curves) else ""
    text = text or ("" if any(curve.equilibrium for curve in curves) else NOT_IN_EQUILIBRIUM)
    if text:
        axes.text(0.99, 0.02, text, transform=axes.transAxes, ha="right", va="bottom", fontsize=7.5, color=MUTED)
