"""The group `VTKHDF` of `results.vtkhdf`: a transient unstructured grid as VTK reads it.

Points move, cells do not. Every array has one slab per stored frame; tables of offsets say where it
begins. The file format is VTKHDF 2.x (VTK 9.3, ParaView 5.12 and newer).
"""

from __future__ import annotations

import h5py
import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import Frame, Layout
from contactlab.results.cell_types import connectivity
from contactlab.results.growing import Column, GrowingFile
from contactlab.results.precision import PLACES, SHOWN, placed
from contactlab.results.shown_times import ShownTimes, create_times

OFFSETS = 64  # frames whose offsets are in a chunk
LOOKED_AT = "f4"
"""Type of the fields of frames; of most of them not all digits are kept, see `precision.py`."""


def write_grid(grid: h5py.Group, layout: Layout) -> None:
    """Write the data that VTK reads once: version, topology, and the body of each cell."""
    grid.attrs["Version"] = np.array([2, 3], np.int64)
    kind = b"UnstructuredGrid"
    grid.attrs.create("Type", kind, dtype=h5py.string_dtype("ascii", len(kind)))
    ids, offsets, types = connectivity(layout.bodies)
    counts = {"NumberOfPoints": len(layout.nodes), "NumberOfCells": len(types), "NumberOfConnectivityIds": len(ids)}
    for name, value in counts.items():
        grid[name] = np.array([value], np.int64)
    grid["Connectivity"], grid["Offsets"], grid["Types"] = ids, offsets, types
    grid.create_group("PointData")
    numbers = [np.full(len(body.cells), i, np.int32) for i, body in enumerate(layout.bodies)]
    grid.create_group("CellData")["body"] = np.concatenate(numbers)
    steps = create_times(grid.file)
    steps.create_group("PointDataOffsets")
    steps.create_group("CellDataOffsets")


def frame_bytes(layout: Layout) -> float:
    """Size of a frame as `GridFile` writes it [bytes]."""
    nodes, cells = len(layout.nodes), sum(len(body.cells) for body in layout.bodies)
    vectors = 3 if layout.has_velocity else 2  # positions, displacements, velocities
    contact = 5 if layout.contacts else 0  # a pressure and a state
    shear = 4 if any(contact.friction for contact in layout.contacts) else 0
    variables = len({name for body in layout.bodies for name in body.shown_variables})
    return nodes * (12.0 * vectors + contact + shear) + cells * 4.0 * (6 + 1 + variables)


class GridFile:
    """The arrays of the grid that have a slab per frame. A frame is there once `times` shows it."""

    def __init__(self, growing: GrowingFile, layout: Layout) -> None:
        self.growing, self.layout = growing, layout
        grid = growing.file["VTKHDF"]
        self.nodes, self.cells = len(layout.nodes), sum(len(body.cells) for body in layout.bodies)
        self.points = Column(grid, "Points", LOOKED_AT, self.nodes, (3,))
        self.point_fields = self._point_fields(grid["PointData"])
        self.variables = list(dict.fromkeys(name for body in layout.bodies for name in body.shown_variables))
        self.cell_fields = {"stress": Column(grid["CellData"], "stress", LOOKED_AT, self.cells, (6,))}
        for name in ("von_mises", *self.variables):
            self.cell_fields[name] = Column(grid["CellData"], name, LOOKED_AT, self.cells)
        self.offsets = self._offsets(grid["Steps"])
        self.times = ShownTimes(growing)
        self._spatial, self._stress = np.zeros((self.nodes, 3)), np.zeros((self.cells, 6))

    def _point_fields(self, group: h5py.Group) -> dict[str, Column]:
        vectors = ["displacement", *(["velocity"] if self.layout.has_velocity else [])]
        fields = {name: Column(group, name, LOOKED_AT, self.nodes, (3,)) for name in vectors}
        if self.layout.contacts:
            fields["contact_pressure"] = Column(group, "contact_pressure", LOOKED_AT, self.nodes)
            fields["contact_state"] = Column(group, "contact_state", "u1", self.nodes)
        if any(contact.friction for contact in self.layout.contacts):
            fields["contact_shear"] = Column(group, "contact_shear", LOOKED_AT, self.nodes)
        return fields

    def _offsets(self, steps: h5py.Group) -> list[tuple[Column, int | None]]:
        """Tables of offsets with their stride per frame; None: all ones."""
        n, c = self.nodes, self.cells

        def table(group: h5py.Group, name: str, shape: tuple[int, ...] = ()) -> Column:
            return Column(group, name, "i8", 1, shape, OFFSETS)

        return [
            (table(steps, "PartOffsets"), 0),
            (table(steps, "PointOffsets"), n),
            (table(steps, "NumberOfParts"), None),
            *((table(steps, name, (1,)), 0) for name in ("CellOffsets", "ConnectivityIdOffsets")),
            *((table(steps["PointDataOffsets"], name), n) for name in self.point_fields),
            *((table(steps["CellDataOffsets"], name), c) for name in self.cell_fields),
            (table(steps["CellDataOffsets"], "body"), 0),
        ]

    @property
    def columns(self) -> list[Column]:
        """All datasets that grow by a row for each frame."""
        tables = [column for column, _ in self.offsets]
        return [self.points, *self.point_fields.values(), *self.cell_fields.values(), *tables]

    @property
    def fields(self) -> dict[str, Column]:
        """Arrays of the file that a frame fills, by name."""
        return {"points": self.points, **self.point_fields, **self.cell_fields}

    @property
    def room(self) -> int:
        """Number of frames for which there is room."""
        return self.points.room

    def fill_offsets(self, begin: int, end: int) -> None:
        """Write where frames `begin` to `end` lie in the arrays."""
        rows = np.arange(begin, end)
        for column, stride in self.offsets:
            column.write(begin, np.ones_like(rows) if stride is None else stride * rows, len(rows))

    def write(self, row: int, frame: Frame) -> None:
        """Fill all fields of a frame; nobody sees it yet."""
        spatial = self._spatial
        spatial[:, :2] = frame.displacement
        self.point_fields["displacement"].write(row, placed(spatial, PLACES))
        spatial[:, :2] += self.layout.nodes
        self.points.write(row, placed(spatial, PLACES))
        if self.layout.has_velocity:
            spatial[:, :2] = frame.velocity
            self.point_fields["velocity"].write(row, placed(spatial, SHOWN))
        self._write_contacts(row, frame)
        self._write_cells(row, frame)

    def cut(self, frames: int) -> None:
        """Cut the file to exactly `frames` frames, and no room for more."""
        self.times.cut(frames)
        for column in self.columns:
            column.resize(frames)

    def _write_contacts(self, row: int, frame: Frame) -> None:
        names = {"contact_pressure": "pressure", "contact_shear": "shear", "contact_state": "state"}
        for field in self.point_fields.keys() & names.keys():
            values: Floats = np.zeros(self.nodes)
            for contact in self.layout.contacts:
                values[contact.slave_nodes] += getattr(frame.curves[contact.name], names[field])
            self.point_fields[field].write(row, values if field == "contact_state" else placed(values, SHOWN))

    def _write_cells(self, row: int, frame: Frame) -> None:
        parts = [frame.cells[body.name] for body in self.layout.bodies]
        self._stress[:, :4] = np.concatenate([part["stress"] for part in parts])
        self.cell_fields["stress"].write(row, placed(self._stress, SHOWN))
        for name in ("von_mises", *self.variables):
            values = [part[name] if name in part else np.zeros(len(part["von_mises"])) for part in parts]
            self.cell_fields[name].write(row, placed(np.concatenate(values), SHOWN))
