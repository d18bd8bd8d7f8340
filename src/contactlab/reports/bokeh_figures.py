"""Bokeh figures for pages: readable on white and on black."""

from __future__ import annotations

from typing import Any

from bokeh.plotting import figure

GREY = "#7d8590"  # read on white and on black


def page_figure(**settings: Any) -> Any:
    """A figure as wide as the page, without a ground of its own; `settings` are those of Bokeh's figure."""
    plot = figure(sizing_mode="stretch_width", background_fill_alpha=0.0, border_fill_alpha=0.0, **settings)
    for axis in (plot.xaxis[0], plot.yaxis[0]):
        axis.update(axis_label_text_color=GREY, major_label_text_color=GREY, axis_line_color=GREY)
    plot.title.text_color = GREY
    plot.grid.grid_line_alpha = 0.25
    return plot
