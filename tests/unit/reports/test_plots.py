"""Plots show every run, failed ones included, in one colour per algorithm."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.axes import Axes

from contactlab.api.drawing.colours import STYLES, style_of, styles
from contactlab.reports.body_plot import body_figure, outline
from contactlab.reports.cost_plot import cost_figure
from contactlab.reports.pressure_plot import pressure_figure
from contactlab.studies.shape import Shape, von_mises
from contactlab.studies.table import Table


def texts(axes: Axes) -> str:
    return "\n".join(text.get_text() for text in axes.texts)


class TestColours:
    def test_a_name_keeps_its_colour_whoever_is_beside_it(self) -> None:
        alone = styles(["node-on-segment"])["node-on-segment"].colour
        for others in (["mortar-p0", "mortar-p1"], ["my-mortar", "mortar-p1"], [f"a{k}" for k in range(30)]):
            assert styles([*others, "node-on-segment"])["node-on-segment"].colour == alone

    def test_usual_names_have_different_colours(self) -> None:
        names = ["mortar-p0", "mortar-p1", "mortar-dual", "node-on-segment", "gauss-point", "nitsche", "barrier",
                 "midplane", "my-mortar", "my-contact", "gauss-mortar"]  # fmt: skip
        assert len({style_of(name).colour for name in names}) == len(names)

    def test_up_to_eight_names_have_different_markers_and_many_have_different_styles(self) -> None:
        assert len({style.marker for style in styles([f"algorithm-{k}" for k in range(8)]).values()}) == 8
        chosen = styles([f"a{k}" for k in range(20)]).values()
        assert len(set(chosen)) == 20

    def test_the_order_is_that_of_the_names(self) -> None:
        assert list(styles(["z", "a", "m", "a"])) == ["z", "a", "m"]

    def test_neighbouring_colours_differ_in_brightness(self) -> None:
        # Relative luminance after WCAG 2; a tenth apart can be told in grey, and markers help the rest.
        def luminance(rgb: tuple[int, int, int]) -> float:
            linear = [c / 255 / 12.92 if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in rgb]
            return float(np.dot((0.2126, 0.7152, 0.0722), linear))

        found = sorted(luminance(style.rgb) for style in STYLES)
        assert found[0] > 0.1  # not lost on a dark page
        assert found[-1] < 0.5  # nor on a white one
        assert found[-1] - found[0] > 0.2


class TestPressures:
    def test_a_panel_for_every_algorithm_and_slave(self, table: Table) -> None:
        figure = pressure_figure(table)
        assert len(figure.axes) == 4
        assert [axes.get_title(loc="left") for axes in figure.axes[:2]] == ["alpha", "beta"]
        assert "slave: disc" in figure.axes[0].get_ylabel()
        assert "[MPa]" in figure.axes[2].get_ylabel()

    def test_curves_are_the_nodal_pressures(self, table: Table) -> None:
        panel = pressure_figure(table).axes[1]
        drawn = panel.lines[-1].get_xydata()
        row = table.select(algorithm="beta", slave="disc", level=2)[0]
        assert row.curve is not None
        assert np.array_equal(drawn, np.stack([row.curve.x, row.curve.pressure], axis=1))
        assert panel.lines[-1].get_color() == styles(["alpha", "beta"])["beta"].colour

    def test_what_failed_is_said_in_its_panel(self, table: Table) -> None:
        unsettled, _, dead, _ = pressure_figure(table).axes
        assert "not-converged" in texts(unsettled)
        assert unsettled.lines[-1].get_linestyle() == "--"
        assert "failed" in texts(dead)
        assert "SIGKILL" in texts(dead)

    def test_a_peak_beyond_the_axes_is_written(self, table: Table) -> None:
        high = table.rows[0].curve
        assert high is not None
        high.pressure[16] = 5000.0
        panel = pressure_figure(table).axes[0]
        assert "up to 5000 MPa" in texts(panel)
        assert panel.get_ylim()[1] < 1500.0


class TestCost:
    def test_lines_run_over_the_levels(self, table: Table) -> None:
        axes = cost_figure(table).axes[0]
        lines = {tuple(line.get_xdata()): tuple(line.get_ydata()) for line in axes.lines if len(line.get_xdata()) > 1}
        assert lines[12.0, 96.0] in {(0.01, 0.005), (0.03, 0.006)}
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        assert "[s]" in axes.get_xlabel()
        assert "[%]" in axes.get_ylabel()

    def test_ticks_differ_where_all_runs_cost_the_same(self, table: Table) -> None:
        rows = [
            replace(row, measures={**row.measures, "cpu_s": 0.708 + 0.004 * number, "pressure_error": 0.01})
            for number, row in enumerate(table.rows[:3])
        ]
        figure = cost_figure(replace(table, rows=rows))
        figure.draw_without_rendering()
        (axes,) = figure.axes
        for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            shown = [tick.label1.get_text() for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
            assert len(shown) == len(set(shown)) >= 2

    def test_runs_that_did_not_finish_are_crossed_or_named(self, table: Table) -> None:
        axes = cost_figure(table).axes[0]
        assert sum(line.get_marker() == "x" for line in axes.lines) == 1
        assert "alpha, slave block, level 2: failed" in axes.get_title(loc="left").replace("\n", " ")

    def test_the_axes_reach_down_to_the_uncertainty_of_the_reference_only_when_it_matters(self, table: Table) -> None:
        axes = cost_figure(table).axes[0]
        assert "0.10 %" in texts(axes)
        assert axes.get_ylim()[0] > table.reference.pressure_uncertainty  # type: ignore[union-attr]


class TestBodies:
    def test_von_mises_of_uniaxial_and_pure_shear(self) -> None:
        stress = np.array([[5.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0], [7.0, 7.0, 7.0, 0.0]])
        assert von_mises(stress) == pytest.approx([5.0, 2.0 * math.sqrt(3.0), 0.0])

    def test_the_outline_is_what_one_cell_alone_has(self) -> None:
        square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        found = outline(Shape(np.stack([square, square + np.array([1.0, 0.0])]), np.zeros(2)))
        assert len(found) == 6  # eight sides, two of them are one inner side
        length = np.hypot(*(found[:, 1] - found[:, 0]).T).sum()
        assert length == pytest.approx(6.0)

    def test_all_cells_are_drawn(self, table: Table) -> None:
        figure = body_figure(table)
        assert figure is not None
        assert len(figure.axes[0].collections[0].get_paths()) == 2


def test_levels_of_a_line_are_in_order(table: Table) -> None:
    for line in cost_figure(table).axes[0].lines:
        assert all(a <= b for a, b in pairwise(line.get_xdata()))
