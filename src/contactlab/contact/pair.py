"""Base class of contact pairs: from positions to gap constraints, and back to pressures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from time import perf_counter
from typing import ClassVar

import numpy as np

from contactlab.api import (
    ContactMethod,
    ContactView,
    FactoredRows,
    Floats,
    FrictionLaw,
    Ints,
    PointContact,
    Rows,
    State,
    Surface,
)
from contactlab.api.surface import SurfacePositions
from contactlab.contact.sliding import sliding_of
from contactlab.contact.start_gaps import StartGaps
from contactlab.kernels.contact.pair import FAR, write_slips
from contactlab.kernels.contact.search import REACH, Near, longest_segment, take

_ALL = slice(None)
HELD = 2.0  # longest segments of the slave: deeper overlaps are the far side of a thin body for mortars


@dataclass(frozen=True)
class ContactSnapshot:
    """A pair at an accepted step, k multipliers on m slave nodes; it owns the arrays.

    at           deformed positions of both surfaces [mm]
    gaps         (k,) [mm] `FAR` without a constraint
    normals      (k, 2) unit vectors from the master towards the slave
    cover        (k,) [mm] overlap length of each multiplier
    grip         (k,) [mm] length on which a slip stress bounds the tangential force
    forces       (2, k) [N] normal and tangential multipliers y; tangential ones are zero without friction
    tractions    (2, k) [MPa] Lambda = T^-1 y
    """

    at: SurfacePositions
    gaps: Floats
    normals: Floats
    cover: Floats
    grip: Floats
    forces: Floats
    tractions: Floats

    @property
    def resultant(self) -> Floats:
        """Return the sum (2,) [N] of normal and tangential forces on the slave, along its normals."""
        normal, tangential = self.forces
        return np.asarray(normal @ self.normals + tangential @ turned(self.normals))


def turned(vectors: Floats) -> Floats:
    """Return vectors (k, 2) turned by -90 degrees: from normals to tangents."""
    return np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)


class ContactPair(ABC):
    """A slave and a master surface under one contact algorithm.

    Multiplier k = slot * m + i of the pair lives at `first_slot + k` of the state's multipliers, all of them at `own`.

    method     the algorithm
    size       [mm] longest segment of both sides
    held       [mm] penetration up to which constraints of every algorithm hold nodes of the slave
    at         positions of the nodes of both sides at which constraints are made
    gaps       (k, 2) [mm] normal gaps and tangential separations, as last measured
    normals    (k, 2) unit vectors of all multipliers, from the master towards the slave, of the last `update`
    cover      (k,) [mm] overlap length of each multiplier, of the last `update`, 0 without a constraint
    full       (k,) [mm] length of the slave segments at each multiplier, on full overlap, of the last `update`
    start_gaps the share of the initial gaps that does not count; None if they count in full
    sliding    data of friction; None without
    half       True if forces act on the slave alone, as another pass has the sides exchanged
    second     True for this other pass, and for points at corners: no report shows them
    points     the pair of points at corners of the master, whose forces are reported with this pair
    memory     (k,) memory of laws for each multiplier, by name: parts of the state
    evaluated  True if the constraints belong to the last accepted step
    search_s   wall time [s] spent on near lists
    """

    normals: Floats
    cover: Floats
    full: Floats

    factored: ClassVar[bool] = False
    """True if constraints can be given as `FactoredRows`."""
    at_corners: ClassVar[bool] = False
    """True if its constraints are points at corners, in addition to another pair."""
    idle: bool = False
    """True if it has no constraints, and needs none."""
    smooth: ClassVar[bool] = False
    """True if gaps are measured between curves through the nodes."""
    by_energy: ClassVar[bool] = False
    """True if forces come from a `Potential`, without constraints."""
    clearance: float = 0.0
    """Gap [mm] at which forces begin."""
    opened: float = 0.0
    """Opening [mm] of touching surfaces before the run: exact constraints would keep this gap."""
    lagged: float = 0.0
    """Largest deviation of friction from its bound under the final normal forces, as a share of the largest force."""

    def __init__(
        self,
        name: str,
        algorithm: ContactMethod,
        slave: Surface,
        master: Surface,
        reference: Floats,
        first_slot: int,
        friction: FrictionLaw | None,
    ) -> None:
        self.name, self.slave, self.master = name, slave, master
        self.first_slot, self.friction = first_slot, friction
        self.method, self.slots = algorithm, algorithm.rows_per_node * len(slave.nodes)
        self.at = SurfacePositions(reference[slave.nodes], reference[master.nodes])
        self.size = longest_segment(self.at, slave, master)
        self.held = min(self.size, HELD * float(slave.lengths(self.at.slave).max()))
        self.near: Near | None = None
        self.gaps = np.full((self.slots, 2), FAR)
        self.start_gaps: StartGaps | None = None
        self.sliding = sliding_of(friction, self.slots, slave, self.at)
        self.half = self.second = False
        self.points: ContactPair | None = None
        self.memory: dict[str, Floats] = {}
        self._view: ContactView | None = None
        self._no_memory = np.zeros((0, len(slave.nodes)))  # always the same, as views of a memory last as it does
        self.search_s = 0.0

    def memory_in(self, state: State) -> Floats:
        """Return the memory (memory_size, m) of the pair's algorithm in the state, and not a copy."""
        name = f"memory.{self.name}"
        return state[name] if name in state else self._no_memory

    @property
    def share(self) -> float:
        """Factor of its work and energy: each of two half passes counts half of the same surfaces."""
        return 0.5 if self.half else 1.0

    @property
    def rows_per_node(self) -> int:
        """Number of multipliers that a slave node can carry."""
        return self.slots // len(self.slave.nodes)

    @property
    def at_points(self) -> bool:
        """True if tractions belong to points, quadratic along quadratic edges like the lengths of points."""
        return isinstance(self.method, PointContact) and not self.method.points

    @property
    def own(self) -> slice:
        """Slice of the model's multipliers that belong to this pair."""
        return slice(self.first_slot, self.first_slot + self.slots)

    @property
    def everywhere(self) -> bool:
        """True if friction also acts on open nodes, so that every multiplier within the search distance needs a row."""
        return self.sliding is not None and self.sliding.everywhere

    @property
    def between(self) -> tuple[Ints, Ints, Ints]:
        """Return slave nodes without multiplier, and the next and previous node with a multiplier for each."""
        none = np.zeros(0, np.int32)
        return none, none, none

    def slips_at_nodes(self, slips: Floats, gaps: Floats) -> Floats:
        """Return slips (m,) [mm] of nodes: mean over multipliers with gaps (k,) below `FAR`, 0 without any."""
        near = (gaps < FAR).reshape(self.rows_per_node, -1)
        total = np.where(near, slips.reshape(near.shape), 0.0).sum(axis=0)
        return np.asarray(total / np.maximum(near.sum(axis=0), 1))

    @abstractmethod
    def calls_per_step(self) -> dict[str, int]:
        """Return how many calls of each method of the algorithm a step or an iteration makes."""

    # --- from positions to constraints -----------------------------------------------------------

    @abstractmethod
    def update(self, positions: Floats, memory: Floats) -> None:
        """Search, make the constraints at `positions` (N, 2), and measure their gaps there."""

    @abstractmethod
    def update_pushed(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """Call `update` at predicted + compliance * force, all (N, 2), and measure gaps at `predicted`."""

    def compute_gaps(self, positions: Floats) -> None:
        """Compute gaps at `positions` (N, 2), with the constraints of the last `update`."""
        self.gaps[:] = self.gaps_at(positions)
        self._take_start_gaps(self.gaps)

    @abstractmethod
    def gaps_at(self, positions: Floats) -> Floats:
        """Return gaps (k, 2) as `compute_gaps`, in a new array, initial gaps counted in full."""

    @abstractmethod
    def compute_start_normals(self, positions: Floats, memory: Floats) -> None:
        """Compute normals of the present constraints at `positions`, the start of the step (friction only)."""

    def find_near(self, slave: Floats, master: Floats) -> Near:
        """Rebuild the near list for these positions of the surfaces (m, 2)."""
        began = perf_counter()
        self.near, self._view = Near.of(self.slave, self.master, slave, master, self.size), None
        self.search_s += perf_counter() - began
        return self.near

    def seen(self, memory: Floats) -> ContactView:
        """Return the algorithm's view of the present positions; the same object as long as its parts are the same."""
        view = self._view
        if view is None or view.memory is not memory:
            assert self.near is not None
            near = self.near.candidates
            self._view = view = ContactView(self.slave, self.master, self.at, near, REACH * self.size, memory)
        return view

    def _start(self, positions: Floats, memory: Floats) -> ContactView:
        """Return the algorithm's view of the start of the step, with friction."""
        assert self.sliding is not None
        began = self.sliding.began
        take(positions, self.slave.nodes, began.slave)
        take(positions, self.master.nodes, began.master)
        return self.sliding.view(self.seen(memory))

    @property
    def start_distance(self) -> Floats | None:
        """Initial distances (k,) [mm] that count as zero gap; None if they count in full."""
        start = self.start_gaps
        return start.value if start is not None and start.lasting else None

    @property
    def pushes_overlaps_out(self) -> bool:
        """True if initial overlaps are pushed out, so that contact adds energy on purpose."""
        return self.start_gaps is not None and self.start_gaps.ramped

    def _take_start_gaps(self, gaps: Floats) -> None:
        """Subtract from the normal gaps (k, 2) [mm] the share that does not count."""
        if self.start_gaps is not None and (share := self.start_gaps.uncounted()) != 0.0:
            gaps[:, 0] -= share * self.start_gaps.value

    # --- from constraints to rows ----------------------------------------------------------------

    def append_factored(self, out: FactoredRows) -> bool:
        """Append all constraints to `out`; False if `out` is too small. Only for pairs that are `factored`."""
        raise NotImplementedError(f"{type(self).__name__} gives no factored rows")

    @abstractmethod
    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`.

        Returns the next free entry, or -1 if `out` is too small. `current` (N, 2) are the
        positions at the start of the step, used with friction.
        """

    def write_bounds(self, out: Rows, first: int, last: int) -> None:
        """Write friction bounds of the rows first ... last - 1."""
        assert self.sliding is not None
        slots = out.slot[first:last] - self.first_slot if self.sliding.varies else _ALL
        out.bound[:, first:last] = self.sliding.of(slots)

    def _append_slips(self, out: Rows, first: int, last: int, current: Floats) -> None:
        """Add friction bounds and slips to the rows first ... last - 1, which have their tangent weights."""
        if self.sliding is not None:
            self.write_bounds(out, first, last)
            measured = self.gaps, self.normals, self.sliding.before
            write_slips(first, last, self.first_slot, measured, current, out)
        elif len(out.slip):
            out.bound[:, first:last] = 0.0
            out.slip[first:last] = 0.0

    # --- from multipliers to pressures ----------------------------------------------------------

    @abstractmethod
    def tractions(self, forces: Floats) -> Floats:
        """Return Lambda (k,) [MPa] of nodal forces y (k,) [N]."""

    def snapshot(self, state: State, position: Floats) -> ContactSnapshot:
        """Return the pair at the accepted step that ends at `position` (N, 2), with the multipliers of the state.

        Constraints stay as they were in this step.
        """
        gaps = self.gaps_at(position)
        self._take_start_gaps(gaps)
        forces = np.zeros((2, self.slots))
        known = state["multipliers"][:, self.own]
        forces[: len(known) if self.friction is not None else 1] = known if self.friction is not None else known[0]
        return ContactSnapshot(
            at=SurfacePositions(position[self.slave.nodes], position[self.master.nodes]),
            gaps=gaps[:, 0],
            normals=self.normals.copy(),
            cover=self.cover.copy(),
            grip=self.cover.copy(),
            forces=forces,
            tractions=np.stack([self.tractions(force) for force in forces]),
        )


def shown(passes: tuple[ContactPair, ...]) -> tuple[ContactPair, ...]:
    """Return the pairs in reports: one for each contact of the scene."""
    return tuple(pair for pair in passes if not pair.second)


def initial_gaps(pair: ContactPair, positions: Floats) -> Floats:
    """Return gaps (k,) [mm] measured by the algorithm at `positions`; `FAR` without a constraint."""
    pair.update(positions, np.zeros((pair.method.memory_size, len(pair.slave.nodes))))
    return np.asarray(pair.gaps[:, 0].copy())


def start_distances(pair: ContactPair, positions: Floats) -> Floats:
    """Return `initial_gaps`; a multiplier without a constraint gets the distance of another multiplier at its node.

    One of the two multipliers of a node at the end of a chain holds it, as one side ends before the other.
    """
    by_node = initial_gaps(pair, positions).reshape(pair.rows_per_node, -1)
    nearest = by_node[np.abs(by_node).argmin(axis=0), np.arange(by_node.shape[1])]
    return np.where(by_node < FAR, by_node, nearest).ravel()
