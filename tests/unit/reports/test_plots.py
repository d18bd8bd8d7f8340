"""Plots show every run, failed ones included, in one colour per algorithm."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.axes import Axes

from contactlab.api.drawing.colours import styles
from contactlab.reports.cost_plot import cost_figure
from contactlab.reports.notebook.pictures import limits_of
from contactlab.reports.pressure_plot import pressure_figure
from contactlab.studies.shape import von_mises
from contactlab.studies.table import Table


def texts(axes: Axes) -> str:
    return "\n".join(text.get_text() for text in axes.texts)


class TestColours:
    def test_a_name_keeps_its_colour_whoever_is_beside_it(self) -> None:
        alone = styles(["node-on-segment"])["node-on-segment"].colour
        for others in (["mortar-p0", "mortar-p1"], ["my-mortar", "mortar-p1"], [f"a{k}" for k in range(30)]):
            assert styles([*others, "node-on-segment"])["node-on-segment"].colour == alone

    def test_fields_beside_each_other_have_the_range_of_all(self) -> None:
        """In whatever order: the largest value of one run must not be cut by the next."""
        fields = [{"block": np.linspace(0.0, most, 1001)} for most in (10.0, 2.0)]
        assert limits_of(fields) == limits_of(fields[::-1])
        assert limits_of(fields)[1] > 9.0


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

    def test_runs_that_did_not_finish_are_crossed_or_named(self, table: Table) -> None:
        axes = cost_figure(table).axes[0]
        assert sum(line.get_marker() == "x" for line in axes.lines) == 1
        assert "alpha, slave block, level 2: failed" in axes.get_title(loc="left").replace("\n", " ")


class TestBodies:
    def test_von_mises_of_uniaxial_and_pure_shear(self) -> None:
        stress = np.array([[5.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0], [7.0, 7.0, 7.0, 0.0]])
        assert von_mises(stress) == pytest.approx([5.0, 2.0 * math.sqrt(3.0), 0.0])
