"""Results of a run: the summary, histories, contact curves and fields at the end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.api.frame import ContactCurve, Event, Frame, Iterate, IterationRow, Layout
from contactlab.api.thinning import Thinning
from contactlab.api.warning import RunWarning
from contactlab.results.named import Named
from contactlab.results.stored_sequence import NoneStored
from contactlab.views import view

if TYPE_CHECKING:
    import pandas as pd
    import pyvista as pv
    import xarray as xr
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FRAMES_IN_FILES = (
    'frames are kept in files: simulate(scene, out="runs/mine"); without, displacement, velocity and stress are those '
    "of the end, which plot() and mesh() show"
)

__all__ = ["ContactCurve", "ContactHistory", "Results"]


@dataclass(repr=False)
class ContactHistory:
    """The stored curves of one contact: `times` (frames,) [s] and the curves; and its record of every step."""

    times: list[float] = field(default_factory=list)
    curves: list[ContactCurve] = field(default_factory=list)
    step_source: Sequence[np.ndarray] = ()

    @property
    def steps(self) -> np.ndarray:
        """Contact data of each slave node in every kept step: rows of `contactlab.api.contact_steps.contact_record`.

        `steps["pressure"]` is (steps, m), `steps["step"]` (steps,); empty without files. Read again at every call.
        """
        blocks = list(self.step_source)
        return np.concatenate(blocks) if blocks else np.zeros(0, _NOTHING_RECORDED)

    @property
    def last(self) -> ContactCurve:
        """The curve of the last stored frame."""
        if not self.curves:
            raise LookupError("no frame was stored for this contact")
        return self.curves[-1]

    def __repr__(self) -> str:
        return f"ContactHistory({len(self.curves)} curves)"


_NOTHING_RECORDED = np.dtype([
    ("step", "i8"), ("time", "f8"), ("gap", "f4", (0,)), ("pressure", "f4", (0,)), ("state", "u1", (0,)),
    ("segment", "u2", (0,)),
])  # fmt: skip


@dataclass(eq=False, repr=False)
class Results:
    """A finished, failed or interrupted run.

    summary       the content of `summary.json` (see docs/scene-format.md)
    layout        bodies, contacts, parts and versions; what does not change in time
    history       columns of `history.csv` by name, each (frames,)
    contact       stored curves of each contact, by "contacts.0", by the contact's name and by "disc.arc on block.top"
    displacement  (N, 2) [mm] and velocity (N, 2) [mm/s] ((0, 2) in statics) at the end
    stress        Cauchy stress of each body at the end, (n, q, 4) xx yy zz xy [MPa]
    internal_variables  of each body whose law has any, by name (n, q), at the end
    events        log of the run: steps shortened, warnings when they came
    iterations    every Newton iteration of implicit runs, also of rejected steps
    iterates      displacements and gaps after the iterations that were kept, read on access; empty without files
    frames        every stored frame with its fields, read from `results.vtkhdf` on access; empty without files
    last_steps    frames of every one of the last steps before a "failure" or the first "warning" of a guard, if any
    folder        where the files are, None if none were written
    watched       findings of each watch, by its name; of the run just made, not read back from files
    lost          data of a damaged file that could not be read, if it was loaded with `salvage`
    closed        False if the files are from a run that was killed, or still goes on

    The end is the last state that was saved: of a run without files, or a finished run, its last step.
    """

    summary: dict[str, Any]
    layout: Layout
    history: dict[str, Floats]
    contact: dict[str, ContactHistory]
    displacement: Floats
    velocity: Floats
    stress: dict[str, Floats]
    internal_variables: dict[str, dict[str, Floats]]
    events: Sequence[Event] = ()
    iterations: Sequence[IterationRow] = ()
    iterates: Sequence[Iterate] = ()
    frames: Sequence[Frame] = ()
    last_steps: Mapping[str, Sequence[Frame]] = field(default_factory=dict)
    folder: Path | None = None
    step_source: Sequence[Floats] = ()
    closed: bool = True
    watched: dict[str, dict[str, Floats]] = field(default_factory=dict)
    lost: Sequence[str] = ()

    def __post_init__(self) -> None:
        self.history = Named.of("history column", self.history)
        self.contact = Named.of("contact", self.contact, same={c.title: c.name for c in self.layout.contacts})
        if not len(self.frames) and self.folder is None:
            self.frames = NoneStored.of("frame", FRAMES_IN_FILES)

    @property
    def status(self) -> str:
        """finished, diverged, not-converged, refused, interrupted or failed."""
        return str(self.summary["status"])

    @property
    def reason(self) -> str:
        """Why the run did not finish; empty when it did."""
        return str(self.summary["reason"])

    @property
    def warnings(self) -> list[RunWarning]:
        """Warnings of this run, each with its value and limit; see docs/warnings.md."""
        return [RunWarning.from_data(data) for data in self.summary.get("warnings", ())]

    @property
    def restartable(self) -> bool:
        """Return whether there is a last state with fields at every point."""
        return bool(self.stress)

    @property
    def nodes(self) -> Floats:
        """Reference positions (N, 2) [mm]."""
        return self.layout.nodes

    @property
    def cells(self) -> dict[str, Ints]:
        """Cells of each body by name, in global node numbers."""
        return {body.name: body.cells for body in self.layout.bodies}

    @property
    def steps(self) -> Mapping[str, Floats]:
        """Scalars of every step by name, each (steps,); empty without files. Read again at every call."""
        blocks = list(self.step_blocks())
        values = np.concatenate(blocks) if blocks else np.zeros((0, 0))
        columns = {name: values[:, i] for i, name in enumerate(self.layout.steps)} if blocks else {}
        return Named.of("scalar of steps", columns, 'they are kept in files: simulate(scene, out="runs/mine")')

    @property
    def step_count(self) -> int:
        """Steps whose scalars were recorded."""
        return _rows_of(self.step_source)

    def step_blocks(self) -> Iterator[Floats]:
        """The same (b, len(layout.steps)), some steps at a time."""
        yield from self.step_source

    @property
    def contact_step_count(self) -> int:
        """Steps of which the contacts were recorded node by node."""
        return _rows_of(self._record(self.layout.contacts[0].name)) if self.layout.contacts else 0

    @property
    def thinned(self) -> Mapping[str, Thinning]:
        """Thinning of the scalars of `steps` and of the `contact` record because `record.budget` was used up.

        Of the steps up to `until` only each `stride`th is there, and all in which a contact state changed.
        """
        return {name: Thinning(**values) for name, values in self.summary.get("thinned", {}).items()}

    def contact_step_blocks(self) -> Iterator[Mapping[str, np.ndarray]]:
        """The record of all contacts by name, some steps at a time."""
        sources = {contact.name: iter(self._record(contact.name)) for contact in self.layout.contacts}
        waiting: dict[str, np.ndarray] = {}
        while sources:
            for name, source in sources.items():
                if not len(waiting.get(name, ())):
                    waiting[name] = next(source, np.zeros(0))
            size = min(len(rows) for rows in waiting.values())
            if not size:
                return
            yield {name: rows[:size] for name, rows in waiting.items()}
            waiting = {name: rows[size:] for name, rows in waiting.items()}

    def _record(self, contact: str) -> Sequence[np.ndarray]:
        return self.contact[contact].step_source if contact in self.contact else ()

    def __repr__(self) -> str:
        return str(view("notebook.texts.results_text")(self))

    def _repr_html_(self) -> str:
        return str(view("notebook.html.results_html")(self))

    def plot(self, field: str = "von_mises", frame: int = -1, ax: Axes | None = None, flat: bool = False) -> Figure:
        """Draw the deformed bodies with supports and loads, coloured by a field, at a stored frame (the last one).

        Fields: von_mises, pressure (hydrostatic), stress_xx, stress_yy, stress_zz, stress_xy, principal_1 to
        principal_3, displacement and velocity and their _x and _y, and internal variables such as plastic_strain.
        Nodal averages are shown, or with `flat` the mean of each cell. `ax`: matplotlib axes to draw into. Raises
        RequestError for another field or frame.
        """
        figure: Figure = view("notebook.pictures.field_figure")(self, field, frame, ax, flat)
        return figure

    def plot_force(self, on: str = "", component: str = "", ax: Axes | None = None) -> Figure:
        """Draw force against displacement.

        on         a support, "clip.root", or a contact; default: the support that moves most
        component  of the force: "x", "y" or "magnitude"; default: along the motion
        """
        figure: Figure = view("notebook.curves.force_figure")(self, on, component, ax)
        return figure

    def plot_pressure(self, contact: str = "", ax: Axes | None = None) -> Figure:
        """Draw pressure and shear along the slave at the last stored frame, of one contact or of all."""
        figure: Figure = view("notebook.curves.pressure_figure")(self, contact, ax)
        return figure

    def animate(
        self, field: str = "von_mises", stride: int = 1, ax: Axes | None = None, flat: bool = False
    ) -> FuncAnimation:
        """Animate every `stride`th stored frame.

        `animation.save("clip.gif")` writes a file (mp4 needs ffmpeg); `to_jshtml()` is for notebooks.
        """
        animation: FuncAnimation = view("notebook.pictures.field_animation")(self, field, stride, ax, flat)
        return animation

    def to_frame(self) -> pd.DataFrame:
        """Give `history` as a pandas frame, time as index; units are in `attrs["units"]`."""
        frame: pd.DataFrame = view("notebook.frames.history_frame")(self)
        return frame

    def to_xarray(self) -> xr.Dataset:
        """Give all that is stored over time as an xarray data set with units: histories, contact curves, fields."""
        data: xr.Dataset = view("notebook.frames.results_dataset")(self)
        return data

    def mesh(self, frame: int = -1) -> pv.UnstructuredGrid:
        """Give the deformed cells at a stored frame as a PyVista mesh.

        Point data: displacement, velocity, contact_pressure, contact_shear, contact_state (NaN off the slaves).
        Cell data: stress, von_mises, principal_1 to principal_3, pressure, internal variables, body.
        """
        grid: pv.UnstructuredGrid = view("notebook.grid.grid")(self, frame)
        return grid

    def view(self) -> Any:
        """The timeline in the viewer: inline where a notebook can show it, else in a window of its own."""
        return view("notebook.grid.show_timeline")(self)

    def __eq__(self, other: object) -> bool:
        """The same run to the last bit, wherever its files are."""
        return isinstance(other, Results) and _same(_content(self), _content(other))

    __hash__ = None  # type: ignore[assignment]


def _rows_of(blocks: Sequence[np.ndarray]) -> int:
    total = getattr(blocks, "total", None)  # of stored ones it is known without reading them
    return sum(map(len, blocks)) if total is None else int(total)


def _content(results: Results) -> dict[str, Any]:
    skipped = ("layout", "iterates", "frames", "last_steps", "folder", "step_source", "closed", "watched", "lost")
    own = {name: value for name, value in vars(results).items() if name not in skipped}
    return own | {"scene": results.layout.scene, "nodes": results.nodes, "cells": results.cells, "steps": results.steps}


def _same(a: Any, b: Any) -> bool:
    """Equality that looks into arrays and takes nan for equal to nan."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        floats = np.issubdtype(np.asarray(a).dtype, np.floating)
        return bool(np.array_equal(a, b, equal_nan=bool(floats)))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_same(value, b[key]) for key, value in a.items())
    if isinstance(a, ContactHistory) and isinstance(b, ContactHistory):
        return _same(a.times, b.times) and a.curves == b.curves and a.steps.tobytes() == b.steps.tobytes()
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)
