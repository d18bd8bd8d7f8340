"""The result of a comparison: one row per run, failures included."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactlab.api.arrays import Floats
from contactlab.api.warning import RunWarning
from contactlab.results.named import Named
from contactlab.results.results import ContactCurve
from contactlab.studies.columns import BY_NAME, MEASURES, Column
from contactlab.studies.cost_breakdown import CostBreakdown
from contactlab.studies.measure_run import carried_load
from contactlab.studies.profile import FoldedSurfaceError, Profile
from contactlab.studies.reference import Reference
from contactlab.studies.shape import Shape
from contactlab.studies.study import Study
from contactlab.views import view

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Row:
    """Run of a study as a row of its table.

    name       of its folder, unique in the table
    algorithm  contact algorithm of the compared contact
    slave      body whose surface is the slave
    level      of the mesh
    varied     scene keys that the study sets, and their values
    choices    `varied` without algorithm, slave and level
    status     finished, diverged, not-converged, refused, interrupted, timed-out or failed
    reason     why it did not finish; empty when it did
    measures   numbers by name (`columns.MEASURES` and installed ones), `nan` if one has no meaning
    notes      why measures are missing
    warnings   warnings of the run
    system     machine and versions
    parts      parts by role, as in the run's summary
    reference  name of the reference the measures compare with, empty for none
    curve      last contact curve, None if the run left none
    shapes     deformed bodies by name
    refines    True for a run that is only there for the error at another level
    history    columns of its `history.csv` by name
    path       what its stored states are: "in time", "quasi-static", or "the end only" (`contactlab.results.summary`)
    share      share of the load or of the declared time that it came to
    """

    name: str
    algorithm: str
    slave: str
    level: int
    varied: Mapping[str, Any]
    status: str
    reason: str
    measures: Mapping[str, float] = field(default_factory=dict)
    notes: Sequence[str] = ()
    warnings: Sequence[RunWarning] = ()
    system: Mapping[str, Any] = field(default_factory=dict)
    parts: Mapping[str, Any] = field(default_factory=dict)
    reference: str = ""
    choices: Mapping[str, Any] = field(default_factory=dict)
    curve: ContactCurve | None = None
    shapes: Mapping[str, Shape] = field(default_factory=dict)
    refines: bool = False
    history: Mapping[str, Floats] = field(default_factory=dict)
    path: str = ""
    share: float = 1.0

    @property
    def finished(self) -> bool:
        """Return whether the run finished."""
        return self.status == "finished"

    @property
    def complete(self) -> bool:
        """Return whether the whole load was applied, settled or not: only then are pressures compared."""
        return carried_load(self.status, self.share)

    @cached_property
    def profile(self) -> Profile | None:
        """Contact pressure over deformed x; None without a curve or on a folded surface."""
        if self.curve is None or not len(self.curve.x):
            return None
        try:
            return Profile.of_curve(self.curve)
        except FoldedSurfaceError:
            return None

    def __getitem__(self, name: str) -> Any:
        """A value by the name of its column in `table.csv`. Raises KeyError with the nearest name."""
        return Named.of("column", self.record())[name]

    def __repr__(self) -> str:
        return f"Row({self.name}: {self.status}{f', {self.reason}' if self.reason else ''})"

    def record(self) -> dict[str, Any]:
        """Everything of the run but its curve, flat, by column name."""
        return {
            "name": self.name,
            "algorithm": self.algorithm,
            "slave": self.slave,
            "level": self.level,
            "status": self.status,
            "reason": self.reason,
            **{name: self.measures.get(name, math.nan) for name in dict.fromkeys((*BY_NAME, *self.measures))},
            "reference": self.reference,
            "notes": "; ".join(self.notes),
            "warnings": "; ".join(dict.fromkeys(warning.code for warning in self.warnings)),
            **self.varied,
            **self.system,
        }


@dataclass(frozen=True, repr=False)
class Table:
    """All rows of a comparison, in the order of the study.

    study        what was compared
    reference    what the pressures were measured against, None if nothing fits
    scene        TOML data of the common scene
    scene_text   the same as TOML
    wall_s       wall time of the whole comparison [s]
    folder       where the files are, None if none were written
    breakdown         costs of the effects of the scene, if requested
    interrupted  True after Ctrl-C or SIGTERM: runs that had not ended are rows of that status
    further      columns of installed measures, in addition to the columns of every table
    """

    rows: Sequence[Row]
    study: Study
    reference: Reference | None
    scene: Mapping[str, Any]
    scene_text: str = ""
    wall_s: float = math.nan
    folder: Path | None = None
    breakdown: CostBreakdown | None = None
    interrupted: bool = False
    further: Sequence[Column] = ()

    def __repr__(self) -> str:
        return str(view("notebook.texts.table_text")(self))

    def _repr_html_(self) -> str:
        return str(view("notebook.html.table_html")(self))

    def plot_cost(self, ax: Axes | None = None) -> Figure:
        """Draw error against CPU time."""
        figure: Figure = view("cost_plot.cost_figure")(self, ax)
        return figure

    def plot_pressures(self, ax: Axes | None = None) -> Figure:
        """Draw the contact pressure of every run and the reference: a panel per run, or all in the axes `ax`."""
        figure: Figure = view("pressure_plot.pressure_figure")(self, ax)
        return figure

    def plot_force(self, on: str = "", component: str = "", ax: Axes | None = None) -> Figure:
        """Draw force against displacement of every run in one plot.

        on         a support or contact; default: the support that moves most
        component  of the force: "x", "y" or "magnitude"; default: along the motion
        """
        figure: Figure = view("force_plot.force_figure")(self, on, component, ax)
        return figure

    def to_frame(self) -> pd.DataFrame:
        """Give a pandas frame with a row for each run."""
        frame: pd.DataFrame = view("notebook.frames.table_frame")(self)
        return frame

    def to_latex(self) -> str:
        """Give the table as a LaTeX `tabular`, as in `table.tex`."""
        return str(view("table.table_tex")(self))

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, column: str) -> list[Any]:
        """Return a column by its name in `table.csv`."""
        return [row[column] for row in self.rows]

    def select(self, **values: Any) -> list[Row]:
        """Rows whose columns have these values: `select(algorithm="mortar-p0", level=2)`."""
        return [row for row in self.rows if all(row[name] == value for name, value in values.items())]

    @property
    def main(self) -> list[Row]:
        """Rows of the study itself, without the further levels of the plot of error against cost."""
        return [row for row in self.rows if not row.refines]

    @property
    def failed(self) -> list[Row]:
        """Rows of runs that did not finish."""
        return [row for row in self.rows if not row.finished]

    @property
    def measures(self) -> tuple[Column, ...]:
        """Columns of numbers that its rows may have."""
        return (*MEASURES, *self.further)

    def columns(self) -> list[str]:
        """Names of all columns of `table.csv`."""
        return list(dict.fromkeys(name for row in self.rows for name in row.record()))
