"""Templates of pages, in data/report: Jinja fills them, and escapes what is filled in."""

from __future__ import annotations

from functools import cache
from typing import Any

from bokeh.plotting import figure
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from contactlab.reports.html import ASSETS


@cache
def _environment() -> Environment:
    return Environment(loader=FileSystemLoader(ASSETS), autoescape=True, undefined=StrictUndefined, trim_blocks=True)


def filled(name: str, **values: Any) -> str:
    """The template of a name with these values."""
    return _environment().get_template(name).render(**values)


GREY = "#7d8590"  # read on white and on black


def page_figure(**settings: Any) -> Any:
    """A figure as wide as the page, without a ground of its own; `settings` are those of Bokeh's figure."""
    plot = figure(sizing_mode="stretch_width", background_fill_alpha=0.0, border_fill_alpha=0.0, **settings)
    for axis in (plot.xaxis[0], plot.yaxis[0]):
        axis.update(axis_label_text_color=GREY, major_label_text_color=GREY, axis_line_color=GREY)
    plot.title.text_color = GREY
    plot.grid.grid_line_alpha = 0.25
    return plot
