"""A run at one instant as a PyVista mesh, and in the viewer of its timeline."""

from __future__ import annotations

from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np

from contactlab.errors import ContactlabError
from contactlab.parts.registry import default_registry
from contactlab.reports.notebook.fields import PRINCIPAL, moment_of, of_stress
from contactlab.reports.notebook.libraries import library
from contactlab.results.cell_types import connectivity
from contactlab.results.results import Results
from contactlab.studies.shown_file import recording_of, showing_recorder


def grid(results: Results, frame: int) -> Any:
    """The deformed cells of all bodies as pyvista.UnstructuredGrid, fields as point and cell data."""
    pyvista = library("pyvista", "mesh")
    moment = moment_of(results, frame)
    nodes, offsets, types = connectivity(results.layout.bodies)
    counts = np.diff(offsets)
    cells = np.insert(nodes, offsets[:-1], counts)
    made = pyvista.UnstructuredGrid(cells, types, _in_space(moment.position))
    made.point_data["displacement"] = _in_space(moment.displacement)
    if len(moment.velocity):
        made.point_data["velocity"] = _in_space(moment.velocity)
    made.point_data.update(contact_fields(results, frame))
    bodies = results.layout.bodies
    names = dict.fromkeys(name for body in bodies for name in moment.cells[body.name])
    for name in names:
        made.cell_data[name] = np.concatenate([_field(moment.cells[body.name], name) for body in bodies])
    stress = np.concatenate([moment.cells[body.name]["stress"] for body in bodies])
    for name in ("pressure", *PRINCIPAL):
        made.cell_data[name] = of_stress(stress, name)
    made.cell_data["body"] = np.repeat(np.arange(len(bodies)), [len(body.cells) for body in bodies])
    made.field_data["bodies"] = [body.name for body in bodies]
    made.field_data["time"] = [moment.time]
    return made


def contact_fields(results: Results, frame: int) -> dict[str, Any]:
    """Pressure, shear and state (0 open, 1 stick, 2 slip) at the slave nodes of all contacts, NaN at other nodes."""
    fields = {"contact_pressure": "pressure", "contact_shear": "shear", "contact_state": "state"}
    found = {name: np.full(len(results.nodes), np.nan) for name in fields} if results.layout.contacts else {}
    for contact in results.layout.contacts:
        curves = results.contact[contact.name].curves
        if not curves:
            continue
        for name, quantity in fields.items():
            before = found[name][contact.slave_nodes]
            found[name][contact.slave_nodes] = np.nan_to_num(before) + getattr(curves[frame], quantity)
    return found


def _in_space(vectors: Any) -> Any:
    return np.column_stack([vectors, np.zeros(len(vectors))])


def _field(cells: Any, name: str) -> Any:
    return cells[name] if name in cells else np.full(len(cells["stress"]), np.nan)


def show_timeline(results: Results) -> Any:
    """The viewer inline where the notebook can show it, else in a window of its own.

    A timeline that is not there is made from what is stored. Raises ContactlabError, saying what is missing, where
    neither is possible.
    """
    recorder = showing_recorder(default_registry())
    if recorder is None:
        raise ContactlabError("no installed recorder makes recordings for a viewer")
    file = recording_of(results, results.folder or Path(mkdtemp(prefix="contactlab-")), recorder)
    inline = recorder.inline(file)
    if inline is not None:
        return inline
    try:
        recorder.show(file, None, None)
    except (RuntimeError, OSError) as error:
        raise ContactlabError(f"{file}: {error}") from error
    return None
