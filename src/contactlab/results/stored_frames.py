"""Stored frames, each read on access."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import ContactCurve, Frame, Layout
from contactlab.results.damage import damage_told
from contactlab.results.frame_sums import StoredSums
from contactlab.results.stored_file import opened
from contactlab.results.stored_sequence import StoredSequence
from contactlab.results.stored_text import read_columns


class _Datasets:
    """Datasets of an open file that stay open: HDF5 then caches decompressed data of several frames."""

    def __init__(self, file: Any) -> None:
        self.file = file
        self.known: dict[str, Any] = {}

    def __getitem__(self, path: str) -> Any:
        if path not in self.known:
            self.known[path] = self.file[path]
        return self.known[path]

    @cached_property
    def history(self) -> list[str]:
        """Names of the columns of the history."""
        return read_columns(self.file["contactlab"], "history")


class StoredFrames(StoredSequence[Frame]):
    """The stored frames of a run with these numbers, each read from the file on access."""

    what = "frame"

    def __init__(self, folder: Path, layout: Layout, numbers: Sequence[int]) -> None:
        self.folder, self.layout, self.numbers = folder, layout, numbers
        self.total = len(numbers)

    def __len__(self) -> int:
        return self.total

    def read(self, number: int) -> Frame:
        """Return frame `number`. Raises RequestError if it is damaged."""
        with opened(self.folder) as file, damage_told(self.folder):
            return self._read(_Datasets(file), StoredSums(file["contactlab"]), self.numbers[number])

    def __iter__(self) -> Iterator[Frame]:
        with opened(self.folder) as file:
            with damage_told(self.folder):
                sums = StoredSums(file["contactlab"]) if self.total else None
            datasets = _Datasets(file)
            for number in self.numbers:
                with damage_told(self.folder):
                    frame = self._read(datasets, sums, number)
                yield frame

    def _read(self, file: _Datasets, sums: StoredSums | None, number: int) -> Frame:
        assert sums is not None
        points = slice(number * len(self.layout.nodes), (number + 1) * len(self.layout.nodes))
        row = sums.check(number, "history", file["contactlab/history"][number])
        scalars = dict(zip(file.history, row.tolist(), strict=True))
        fields = ("displacement", *(("velocity",) if self.layout.has_velocity else ()))
        vectors = {name: sums.check(number, name, file[f"VTKHDF/PointData/{name}"][points]) for name in fields}
        vectors = {name: np.ascontiguousarray(values[:, :2], np.float64) for name, values in vectors.items()}
        return Frame(
            number=number,
            step=int(scalars["step"]),
            time=scalars["time"],
            scalars=scalars,
            curves={
                c.name: ContactCurve.of_table(self._curve(file, sums, c.name, number).T, c.memory)
                for c in self.layout.contacts
            },
            displacement=vectors["displacement"],
            velocity=vectors.get("velocity", np.zeros((0, 2))),
            cells=self._cells(file, sums, number),
        )

    def _curve(self, file: _Datasets, sums: StoredSums, contact: str, number: int) -> Floats:
        stored = file[f"contactlab/contacts/{contact}/curves"][number]
        values: Floats = sums.check(number, f"curves of {contact}", stored)
        return values

    def _cells(self, file: _Datasets, sums: StoredSums, number: int) -> dict[str, dict[str, Floats]]:
        total = sum(len(body.cells) for body in self.layout.bodies)
        here = slice(number * total, (number + 1) * total)
        shown = dict.fromkeys(name for body in self.layout.bodies for name in body.shown_variables)
        names = ("stress", "von_mises", *shown)
        fields = {name: sums.check(number, name, file[f"VTKHDF/CellData/{name}"][here]) for name in names}
        fields = {name: values.astype(np.float64) for name, values in fields.items()}
        found, begin = {}, 0
        for body in self.layout.bodies:
            part = slice(begin, begin + len(body.cells))
            begin = part.stop
            own = ("von_mises", *body.shown_variables)
            found[body.name] = {"stress": fields["stress"][part, :4]} | {name: fields[name][part] for name in own}
        return found
