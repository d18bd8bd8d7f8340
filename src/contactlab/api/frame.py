"""The data of a run for output writers: its layout, stored frames, every step's scalars, and events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from contactlab.api.arrays import Floats, Ints
from contactlab.views import view

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OPEN, STICK, SLIP = 0, 1, 2
"""States of a slave node; frictionless contact counts as slip."""

STATES = ("open", "stick", "slip")
"""Names of the values of `ContactCurve.state`, by number."""


@dataclass(frozen=True, eq=False, repr=False)
class ContactCurve:
    """The contact surface at one instant, one entry per slave node (m,), in chain order.

    s               arc length of the undeformed slave surface [mm]; a chain continues the previous chain
    x, y            deformed position [mm]
    pressure        the multiplier Lambda, positive when pressed [MPa]
    shear           positive along the slave's arc length [MPa]
    nodal_pressure  nodal force per overlap length, never negative [MPa]
    gap             [mm], NaN without overlap
    state           0 open, 1 stick, 2 slip (frictionless contact counts as slip)
    chain           number of the chain that the node belongs to, from 0; sharp corners cut a surface into chains
    memory          what laws of the contact remember, by name
    """

    s: Floats
    x: Floats
    y: Floats
    pressure: Floats
    shear: Floats
    nodal_pressure: Floats
    gap: Floats
    state: Ints
    chain: Ints
    memory: Mapping[str, Floats] = field(default_factory=dict)

    COLUMNS: ClassVar[tuple[str, ...]] = (
        "s", "x", "y", "pressure", "shear", "nodal_pressure", "gap", "state", "chain"
    )  # fmt: skip

    def __eq__(self, other: object) -> bool:
        """Return whether all numbers are equal, with NaN equal to NaN."""
        if not isinstance(other, ContactCurve):
            return NotImplemented
        one, two = self.columns(), other.columns()
        return one.keys() == two.keys() and all(
            np.array_equal(one[name], two[name], equal_nan=name not in ("state", "chain")) for name in one
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        closed, most = int(np.count_nonzero(self.state)), float(np.max(self.pressure, initial=0.0))
        return f"ContactCurve({len(self.s)} nodes, {closed} closed, pressure up to {most:.4g})"

    def columns(self) -> dict[str, np.ndarray]:
        """Return all arrays (m,) by their names in `contact.csv`: "memory.wear" is the wear that a law remembers."""
        named = {name: getattr(self, name) for name in self.COLUMNS}
        return named | {f"memory.{name}": values for name, values in self.memory.items()}

    @classmethod
    def of_table(cls, values: Sequence[Floats] | Floats, memory: Sequence[str] = ()) -> ContactCurve:
        """Build the curve whose `columns` are these arrays of floats: the usual columns, then `memory`."""
        usual, more = values[: len(cls.COLUMNS)], values[len(cls.COLUMNS) :]
        known: dict[str, Any] = dict(zip(cls.COLUMNS, map(np.array, usual), strict=True))
        known |= {name: known[name].astype(np.int32) for name in ("state", "chain")}
        return cls(**known, memory=dict(zip(memory, map(np.array, more), strict=True)))

    def plot(self, units: str = "", ax: Axes | None = None) -> Figure:
        """Draw pressure and shear along the slave; `units` is the label of a scene, `ax` matplotlib axes."""
        figure: Figure = view("notebook.curves.curve_figure")(self, units, ax)
        return figure

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas frame with a row for each slave node."""
        frame: pd.DataFrame = view("notebook.frames.curve_frame")(self)
        return frame


@dataclass(frozen=True)
class BodyLayout:
    """A body: its cells (n, a) in global node numbers, its parts, and the internal variables of its material model.

    Nodes of a cell: corners first, then mid-sides, then the middle; 4, 8 or 9 in all.
    """

    name: str
    element: str
    material: str
    cells: Ints
    internal_variables: tuple[str, ...] = ()

    @property
    def shown_variables(self) -> tuple[str, ...]:
        """Internal variables in stored frames: without the stress that laws in rate form keep in their history."""
        return tuple(name for name in self.internal_variables if not name.startswith("stress_"))


@dataclass(frozen=True)
class ContactLayout:
    """A contact: `name` is "contacts.0", `label` its name in the scene.

    slave, master    edge sets in these roles, "disc.arc"
    *_nodes (m,)     global node numbers of each surface
    *_segments (s, 2)  straight segments, as positions in these nodes
    memory           names of the numbers that its laws remember for each slave node
    """

    name: str
    label: str
    algorithm: str
    slave: str
    master: str
    friction: str
    slave_nodes: Ints
    slave_segments: Ints
    master_nodes: Ints
    master_segments: Ints
    memory: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """The contact's name in the scene, or its sides if it has none: "disc.arc on block.top"."""
        return self.label if self.label != self.name else f"{self.slave} on {self.master}"


@dataclass(frozen=True)
class Layout:
    """All data that does not change during a run.

    scene       the scene as a TOML file, with all defaults
    title       the scene's name; units its label of units
    nodes       (N, 2) reference positions [mm]
    parts       by key of the scene: name and distribution of each part; versions of libraries
    steps       names of the scalars of every step, see docs/results-in-paraview-and-python.md
    has_velocity  False in statics
    frames      stored frames that the scene asks for
    budget      [MB] limit of the contact record, and of the other records of each step
    """

    scene: str
    title: str
    units: str
    nodes: Floats
    bodies: tuple[BodyLayout, ...]
    contacts: tuple[ContactLayout, ...]
    supports: tuple[str, ...]
    parts: Mapping[str, str]
    versions: Mapping[str, str]
    steps: tuple[str, ...]
    has_velocity: bool
    frames: int
    budget: float = 64.0


@dataclass(frozen=True, eq=False)
class Frame:
    """A stored frame.

    scalars       the row of `history.csv`: reactions, energies, contact scalars
    curves        of each contact, by "contacts.0"
    displacement  (N, 2) [mm]; velocity (N, 2) [mm/s], (0, 2) in statics
    cells         per body and cell: "stress" (n, 4) mean of the Cauchy stress xx yy zz xy and "von_mises" (n,)
                  mean over its points [MPa], and the mean (n,) of each internal variable by name
    """

    number: int
    step: int
    time: float
    scalars: Mapping[str, float]
    curves: Mapping[str, ContactCurve]
    displacement: Floats
    velocity: Floats
    cells: Mapping[str, Mapping[str, Floats]]


Level = Literal["info", "warning", "error"]


class Event(NamedTuple):
    """A notable event of a run, with its step and time [s]."""

    step: int
    time: float
    level: Level
    text: str


class IterationRow(NamedTuple):
    """A Newton iteration of an attempted step; iterations of rejected attempts stay in the record.

    step, time [s], dt [s]  number of the step, time at its start, and its length
    attempt, number         attempt at this step, from 1, and iteration within it
    force, contact          residuals, see `contactlab.api.Iteration`, as for the other fields
    statuses                contact states as digits, contact after contact in slave node order; `active_set` as numbers
    """

    step: int
    time: float
    dt: float
    attempt: int
    number: int
    force: float
    contact: float
    active: int
    sticking: int
    changed: int
    length: float
    note: str
    statuses: str = ""

    @property
    def active_set(self) -> Ints:
        """The state of each contact constraint (k,) after the iteration: OPEN, STICK or SLIP."""
        return np.frombuffer(self.statuses.encode(), np.uint8).astype(np.int32) - ord("0")


class Iterate(NamedTuple):
    """The state of bodies and contacts after one Newton iteration, in single precision.

    number        of the iteration among all of the run, from 1: `iterations[number - 1]` has its residuals
    displacement  (N, 2) [mm]
    gap           (k,) [mm] of contact constraints, in the order of `IterationRow.active_set`; NaN: no constraint
    """

    number: int
    displacement: np.ndarray
    gap: np.ndarray


class StoredRun(Protocol):
    """A run read back from its files, complete or not."""

    layout: Layout
    summary: dict[str, Any]

    @property
    def frames(self) -> Sequence[Frame]:
        """All stored frames, each read when it is accessed."""
        ...

    @property
    def last_steps(self) -> Mapping[str, Sequence[Frame]]:
        """Frames of each of the last steps before a failure or warning, by the names in `contactlab.api.recorder`."""
        ...

    @property
    def events(self) -> Sequence[Event]:
        """All events of the run in order of time."""
        ...

    @property
    def iterations(self) -> Sequence[IterationRow]:
        """All Newton iterations of the run, with rejected steps."""
        ...

    @property
    def iterates(self) -> Sequence[Iterate]:
        """Bodies and contacts after the iterations that were kept, each read when it is accessed."""
        ...

    @property
    def step_count(self) -> int:
        """Number of steps whose scalars `step_blocks` gives."""
        ...

    def step_blocks(self) -> Iterator[Floats]:
        """Yield the scalars of every step (b, len(layout.steps)), block after block."""
        ...

    @property
    def contact_step_count(self) -> int:
        """Number of steps that `contact_step_blocks` gives."""
        ...

    def contact_step_blocks(self) -> Iterator[Mapping[str, np.ndarray]]:
        """Yield the record of all contacts, rows of `contactlab.api.contact_steps.contact_record` by contact."""
        ...
