"""What a run keeps while it goes on, and the files it leaves."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contactlab.model.model import Model
from contactlab.results.frame import Frame
from contactlab.results.results import ContactCurve, ContactHistory, Results


class Recording:
    """Frames of one run in memory; `history.csv` grows with every stored frame."""

    def __init__(self, model: Model, scene_text: str, labels: Mapping[str, str], folder: Path | None) -> None:
        self.model, self.labels, self.folder = model, labels, folder
        self.rows: list[dict[str, float]] = []
        self.contact = {name: ContactHistory() for name in labels}
        self.last: Frame | None = None
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "scene.toml").write_text(scene_text)

    def add(self, frame: Frame) -> None:
        """Keep a frame and write its row."""
        row = frame.scalars()
        self.rows.append(row)
        self.last = frame
        for name, report in frame.contacts.items():
            self.contact[name].times.append(frame.time)
            self.contact[name].curves.append(report.curve)
        if self.folder is not None:
            with (self.folder / "history.csv").open("a" if len(self.rows) > 1 else "w", newline="") as file:
                writer = csv.DictWriter(file, list(row))
                if len(self.rows) == 1:
                    writer.writeheader()
                writer.writerow(row)

    def finish(self, summary: dict[str, Any]) -> Results:
        """Write the last files and hand everything back."""
        model = self.model
        if self.folder is not None:
            self._write_contacts()
            (self.folder / "summary.json").write_text(json.dumps(_plain(summary), indent=1))
        names = self.contact | {label: self.contact[name] for name, label in self.labels.items()}
        columns = {key: np.array([row[key] for row in self.rows]) for key in (self.rows[0] if self.rows else {})}
        return Results(
            summary=summary,
            history=columns,
            contact=names,
            nodes=model.reference,
            displacement=model.state["displacement"].copy(),
            cells={body.name: body.cells for body in model.bodies},
            stress={forces.body.name: forces.stress() for forces in model.forces},
            folder=self.folder,
        )

    def _write_contacts(self) -> None:
        assert self.folder is not None
        with (self.folder / "contact.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(("contact", *ContactCurve.COLUMNS))
            for name, history in self.contact.items():
                if not history.curves:
                    continue
                columns = [getattr(history.last, column) for column in ContactCurve.COLUMNS]
                writer.writerows((name, *values) for values in zip(*columns, strict=True))


def _plain(value: Any) -> Any:
    """NumPy numbers and arrays as JSON knows them; nan and inf become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(item) for item in value]
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
