"""Runs, curves and tables as pandas frames and xarray data sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from contactlab.api.drawing.units import Units
from contactlab.api.frame import ContactCurve
from contactlab.reports.notebook.libraries import library
from contactlab.results.results import Results
from contactlab.studies.table import Table
from contactlab.verdicts.files import rows
from contactlab.verdicts.run import Matrix


def history_frame(results: Results) -> Any:
    """`history.csv`: a row per stored frame, its time as index."""
    pandas = library("pandas", "to_frame")
    frame = pandas.DataFrame(results.history)
    units = Units.of_label(results.layout.units)
    frame.attrs["units"] = {name: unit for name in frame if (unit := unit_of(name, units))}
    return frame.set_index("time") if "time" in frame else frame


def unit_of(column: str, units: Units) -> str:
    """The unit of a column of `history.csv`, of a curve or of a field; empty without one."""
    last = column.rpartition(".")[2]
    if column.startswith("energy."):
        return "" if last == "error" else units.line_energy
    if last in ("ux", "uy", "s", "x", "y", "gap", "max_penetration", "position", "displacement"):
        return units.length
    if last in ("fx", "fy"):
        return units.line_force
    if last in ("pressure", "shear", "nodal_pressure", "max_pressure", "von_mises") or last.startswith("stress_"):
        return units.pressure
    if last == "velocity":
        return f"{units.length}/{units.time}" if units.length else ""
    return units.time if last == "time" else ""


def curve_frame(curve: ContactCurve) -> Any:
    """A row per slave node."""
    return library("pandas", "to_frame").DataFrame(curve.columns())


def table_frame(table: Table) -> Any:
    """A row per run, the columns of `table.csv`."""
    return library("pandas", "to_frame").DataFrame([row.record() for row in table.rows])


def matrix_frame(matrix: Matrix) -> Any:
    """A row per measure, the columns of `matrix.csv`."""
    return library("pandas", "to_frame").DataFrame(list(rows(matrix)))


def results_dataset(results: Results) -> Any:
    """All that is stored over time: histories, contact curves, displacements and the fields of each body.

    Dimensions: time, node, component (x, y), `BODY_cell` of each body, and `CONTACT_node` of each contact.
    """
    xarray = library("xarray", "to_xarray")
    times = results.history.get("time", np.zeros(0))
    data: dict[str, Any] = {name: ("time", values) for name, values in results.history.items() if name != "time"}
    data |= _curves(results)
    if len(results.frames):
        data |= _fields(results)
    units = Units.of_label(results.layout.units)
    data = {
        name: (*entry, {"units": unit}) if (unit := unit_of(name, units)) else entry for name, entry in data.items()
    }
    attributes = {"scene": results.layout.title, "units": results.layout.units, "status": results.status}
    coordinates = {"time": ("time", times, {"units": units.time}), "component": ["x", "y"]}
    return xarray.Dataset(data, coordinates, attributes)


def _curves(results: Results) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for contact in results.layout.contacts:
        curves = results.contact[contact.name].curves
        for name in ContactCurve.COLUMNS if curves else ():
            values = np.stack([getattr(curve, name) for curve in curves])
            found[f"{contact.name}.{name}"] = (("time", f"{contact.name}_node"), values)
    return found


def _fields(results: Results) -> dict[str, Any]:
    frames = list(results.frames)
    found: dict[str, Any] = {
        "position": (("node", "component"), results.nodes),
        "displacement": (("time", "node", "component"), np.stack([frame.displacement for frame in frames])),
    }
    if results.layout.has_velocity:
        found["velocity"] = (("time", "node", "component"), np.stack([frame.velocity for frame in frames]))
    for body in results.layout.bodies:
        found |= _body_fields(body.name, [frame.cells[body.name] for frame in frames])
    return found


def _body_fields(body: str, cells: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in cells[0]:
        stacked = np.stack([cell[name] for cell in cells])
        if name == "stress":
            for number, component in enumerate(("xx", "yy", "zz", "xy")):
                found[f"{body}.stress_{component}"] = (("time", f"{body}_cell"), stacked[:, :, number])
        else:
            found[f"{body}.{name}"] = (("time", f"{body}_cell"), stacked)
    return found
