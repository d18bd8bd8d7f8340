"""Figures that show themselves in notebooks, and axes to draw into: new axes, or axes of the caller."""

from __future__ import annotations

import io
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.api.drawing.units import Units
from contactlab.reports.figures import house_style, is_laid_out

WIDTH = 7.6  # inches


class Plot(Figure):
    """A figure that shows itself in a notebook, whether or not pyplot is used there."""

    def savefig(self, *arguments: Any, **settings: Any) -> None:
        """Write the figure. Its layout takes two passes: after one alone, a title above wide axes may be cut off."""
        with house_style():
            if not is_laid_out(self):
                self.draw_without_rendering()
            super().savefig(*arguments, **settings)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=110)
        return buffer.getvalue()


def canvas(ax: Axes | None, height: float, width: float = WIDTH) -> tuple[Figure, Axes]:
    """The axes of the caller with their figure, or new ones so many inches high and wide."""
    if ax is not None:
        return figure_of(ax), ax
    figure = Plot(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def figure_of(ax: Axes) -> Figure:
    """The whole figure of axes, which may lie in a part of it."""
    figure = ax.get_figure(root=True) if _knows_roots(ax) else ax.figure
    assert isinstance(figure, Figure)
    return figure


def _knows_roots(ax: Axes) -> bool:
    try:
        ax.get_figure(root=True)
    except TypeError:  # matplotlib before 3.10
        return False
    return True


def with_unit(text: str, unit: str) -> str:
    """A label with its unit in brackets."""
    return f"{text} [{unit}]" if unit else text


def label_places(axes: Axes, units: str, title: str) -> None:
    """Label axes on which bodies are drawn."""
    length = Units.of_label(units).length
    axes.set_xlabel(with_unit("x", length))
    axes.set_ylabel(with_unit("y", length))
    axes.set_title(title)
