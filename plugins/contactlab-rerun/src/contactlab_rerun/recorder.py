"""The recorder `rerun`. The library is imported when a recording begins or is shown, not before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from contactlab.api.frame import Layout, StoredRun
from contactlab.api.recorder import Recorder, Recording

FILE = "timeline.rrd"
NODE_BYTES = 11.0  # of a stored frame, per node, as measured: position and colour in single precision
STEP_BYTES = 11.0  # of a step, per scalar


@dataclass(frozen=True)
class Rerun(Recorder):
    """Writes `timeline.rrd`: lines of scalars and pictures of the contact record over all steps, and deformed meshes.

    write      when: "run", at the end of the run; "view", at the first look (`contactlab view`), from
               `results.vtkhdf`, so that a run does no work for it (one that stores no results writes it itself)
    field      what colours the mesh: von_mises or (hydrostatic) pressure [MPa], an internal variable of the laws such
               as plastic_strain, or "none"
    every      1: every stored frame is drawn, 2: every other one, ... (the last one always); "auto": as many as fit
               into 0.25 MB, at least 12; curves, tracks and events still have all frames
    wire       draw the sides of all cells; "auto": if there are few enough to be told apart
    lanes      slave nodes of each contact whose state has a track of its own
    panel      show the panel alone whose name has this in it; by default all of them
    """

    by_default: ClassVar[bool] = True
    every_step: ClassVar[bool] = True
    every_contact: ClassVar[bool] = True
    every_iterate: ClassVar[bool] = True
    every_field: ClassVar[bool] = True
    shown_file: ClassVar[str] = FILE

    write: Literal["run", "view"] = "run"
    field: str = "von_mises"
    every: int | Literal["auto"] = "auto"
    wire: bool | Literal["auto"] = "auto"
    lanes: int = 8
    panel: str = ""

    def __post_init__(self) -> None:
        if self.write not in ("run", "view"):
            raise ValueError(f'write: got {self.write}, allowed: "run", "view"')
        if self.every != "auto" and self.every < 1:
            raise ValueError(f'every: got {self.every}, allowed: at least 1, or "auto"')
        if self.lanes < 0:
            raise ValueError(f"lanes: got {self.lanes}, allowed: at least 0")

    @property
    def on_view(self) -> bool:
        """Return whether there is no work during a run."""
        return self.write == "view"

    @property
    def frames_apart(self) -> int:
        """1: all stored frames are kept until the end, 2: every other one."""
        return 1 if self.every == "auto" else self.every

    def disk_bytes(self, layout: Layout, steps: float, memory: float) -> float:
        """Meshes of the frames that are shown, and scalars of all steps."""
        drawn = layout.frames / self.frames_apart
        return NODE_BYTES * len(layout.nodes) * drawn + STEP_BYTES * steps * len(layout.steps)

    def check(self, layout: Layout) -> None:
        """Raise ValueError for a field that no body has."""
        from contactlab_rerun.gathered import check_field

        check_field(self.field, layout)

    def open(self, folder: Path, layout: Layout) -> Recording:
        """Begin to gather; the file is written when the run ends, with one colour scale for all of it."""
        from contactlab_rerun.recording import record_run

        self.check(layout)
        return record_run(self, folder, layout)

    def compared(self, folder: Path, runs: Mapping[str, StoredRun]) -> None:
        """Write one file with all runs side by side."""
        from contactlab_rerun.recording import write_comparison

        write_comparison(self, folder / FILE, runs)

    def show(self, file: Path, png: Path | None, step: int | None, iteration: int | None = None) -> None:
        """Open the viewer, bound to this machine alone; or write a picture without a display."""
        from contactlab_rerun import viewer

        if png is None:
            viewer.open_window(file)
        else:
            viewer.write_picture(file, png, step, iteration)

    def inline(self, file: Path) -> Any:
        """The viewer in a notebook's cell; None without a notebook or without the package rerun-notebook."""
        from contactlab_rerun import viewer

        return viewer.in_cell(file)
