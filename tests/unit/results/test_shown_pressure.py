"""Open nodes show no tension and no shear, and a peak that multipliers alone have is called theirs."""

from __future__ import annotations

import numpy as np

from contactlab.api import ContactCurve
from contactlab.reports.notebook.curves import curve_figure
from contactlab.results.shown_pressure import other_peak, shown_pressure, shown_shear


def test_open_nodes_show_no_traction() -> None:
    """Multipliers of one closed node and its neighbours, which only balance it."""
    x, none = np.linspace(0.0, 1.0, 4), np.zeros(4)
    state, chain = np.array([0, 2, 0, 0], np.int32), np.zeros(4, np.int32)
    pressure, nodal = np.array([-10.7, 40.0, -11.0, 2.9]), np.array([0.0, 27.0, 0.0, 0.0])
    shear = np.array([3.0, -4.0, 1.0, 0.2])
    curve = ContactCurve(x, x, none, pressure, shear, nodal, none, state, chain)
    assert shown_pressure(curve).tolist() == [0.0, 40.0, 0.0, 0.0]
    lines = curve_figure(curve).axes[0].lines
    assert min(np.min(line.get_ydata()) for line in lines) == -4.0
    assert shown_shear(curve).tolist() == [0.0, -4.0, 0.0, 0.0]


def test_a_peak_that_only_multipliers_have_is_told() -> None:
    assert other_peak({"max_pressure": 40.0, "max_nodal_pressure": 27.0}) == 27.0
    assert other_peak({"max_pressure": 40.0, "max_nodal_pressure": 39.0}) is None
    assert other_peak({"max_pressure": 0.0, "max_nodal_pressure": 0.0}) is None
    assert other_peak({"max_pressure": 40.0}) is None
