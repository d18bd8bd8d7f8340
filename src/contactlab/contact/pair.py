"""What every contact pair at work does: from positions to gap conditions, and back to pressures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, ClassVar

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
from contactlab.contact.near_list import REACH, Near, longest_segment
from contactlab.contact.sliding import sliding_of
from contactlab.contact.start_gaps import StartGaps
from contactlab.kernels.contact import rows
from contactlab.kernels.contact.pair import FAR
from contactlab.kernels.contact.search import take

if TYPE_CHECKING:
    from contactlab.contact.smooth_surfaces import SmoothSurfaces

_ALL = slice(None)
HELD = 2.0  # longest segments of the slave: deeper overlaps are the far side of a thin body for mortars


@dataclass(frozen=True)
class ContactSnapshot:
    """One pair at an accepted step, k multipliers on m slave nodes; the arrays are its own.

    at           deformed positions of both surfaces [mm]
    gaps         (k,) [mm] `FAR` where there is no condition
    normals      (k, 2) unit vectors from the master towards the slave
    cover        (k,) [mm] length that each multiplier stands for
    forces       (2, k) [N] normal and tangential multipliers y; tangential ones are zero without friction
    tractions    (2, k) [MPa] Lambda = T^-1 y
    """

    at: SurfacePositions
    gaps: Floats
    normals: Floats
    cover: Floats
    forces: Floats
    tractions: Floats

    @property
    def resultant(self) -> Floats:
        """Sum (2,) [N] of normal and tangential forces on the slave, along its normals."""
        normal, tangential = self.forces
        return np.asarray(normal @ self.normals + tangential @ turned(self.normals))


def turned(vectors: Floats) -> Floats:
    """Vectors (k, 2) turned by -90 degrees: from normals to tangents."""
    return np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)


class ContactPair(ABC):
    """A slave and a master surface under one contact algorithm.

    Multiplier k = slot * m + i of the pair lives at `first_slot + k` of the state's multipliers, all of them at `own`.

    method     the algorithm
    size       [mm] longest segment of both sides
    held       [mm] depth up to which conditions of every algorithm hold nodes of the slave
    at         positions of the nodes of both sides, where conditions are made
    gaps       (k, 2) [mm] normal gaps and tangential separations, where they were last measured
    normals    (k, 2) unit vectors of all multipliers, from the master towards the slave, of the last `update`
    cover      (k,) [mm] length that each multiplier stands for, of the last `update`, 0 without a condition
    full       (k,) [mm] length of the slave segments at each multiplier, on full cover, of the last `update`
    start_gaps what of the gaps at the start does not count; None where they count in full
    smooth     curves that gaps are measured between; None where they are measured between segments
    sliding    what friction needs; None without
    half       whether forces act on the slave alone, as another pass has the sides exchanged
    second     whether it is that other pass, or one of points at corners: no report shows it
    points     the pair of points at corners of the master, whose forces are reported with those of this one
    memory     (k,) what laws remember of each multiplier, by name: parts of the state
    evaluated  whether the conditions are those of the last accepted step
    search_s   wall time [s] spent on near lists
    """

    normals: Floats
    cover: Floats
    full: Floats

    factored: ClassVar[bool] = False
    """Whether conditions can be given as `FactoredRows`."""
    at_corners: ClassVar[bool] = False
    """Whether its conditions are points at corners, beside those of another pair."""
    idle: bool = False
    """Whether it has no conditions, and asks for none."""
    by_energy: ClassVar[bool] = False
    """Whether forces come from a `Potential`, without conditions."""
    clearance: float = 0.0
    """Gap [mm] at which forces begin."""
    opened: float = 0.0
    """[mm] by how much surfaces that touched were opened before the run: exact conditions would keep this gap."""
    lagged: float = 0.0
    """Share of the largest force by which friction may differ from that of the final normal forces."""

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
        self.smooth: SmoothSurfaces | None = None
        self.sliding = sliding_of(friction, self.slots, self.at)
        self.half = self.second = self.evaluated = False
        self.points: ContactPair | None = None
        self.memory: dict[str, Floats] = {}
        self._view: ContactView | None = None
        self.search_s = 0.0

    @property
    def share(self) -> float:
        """How much of its work and of its energy counts: both half passes book those of the same surfaces."""
        return 0.5 if self.half else 1.0

    @property
    def rows_per_node(self) -> int:
        """Multipliers that a slave node can carry."""
        return self.slots // len(self.slave.nodes)

    @property
    def at_points(self) -> bool:
        """Whether tractions belong to points, and are quadratic along quadratic edges as the lengths of points are."""
        return isinstance(self.method, PointContact) and not self.method.points

    @property
    def own(self) -> slice:
        """Which of the model's multipliers are this pair's."""
        return slice(self.first_slot, self.first_slot + self.slots)

    @property
    def everywhere(self) -> bool:
        """Whether friction holds in the air, too, so that every multiplier in reach needs a row."""
        return self.sliding is not None and self.sliding.everywhere

    @property
    def between(self) -> tuple[Ints, Ints, Ints]:
        """Slave nodes that carry no multiplier, and the carriers that follow and precede each."""
        none = np.zeros(0, np.int32)
        return none, none, none

    def slips_at_nodes(self, slips: Floats, gaps: Floats) -> Floats:
        """Slips (m,) [mm] of nodes: means of those (k,) of their multipliers whose gaps (k,) are covered, 0 without."""
        near = (gaps < FAR).reshape(self.rows_per_node, -1)
        total = np.where(near, slips.reshape(near.shape), 0.0).sum(axis=0)
        return np.asarray(total / np.maximum(near.sum(axis=0), 1))

    @abstractmethod
    def calls_per_step(self) -> dict[str, int]:
        """How often a step, or an iteration, calls the algorithm, by what it is asked for."""

    # --- from positions to conditions -----------------------------------------------------------

    @abstractmethod
    def update(self, positions: Floats, memory: Floats) -> None:
        """Search and make the conditions at `positions` (N, 2), and measure their gaps there."""

    @abstractmethod
    def update_pushed(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """`update` at predicted + compliance * force, all (N, 2), and gaps at `predicted`."""

    def compute_gaps(self, positions: Floats) -> None:
        """Gaps at `positions` (N, 2), with the conditions of the last `update`."""
        self.gaps[:] = self.gaps_at(positions)
        self._take_start_gaps(self.gaps)

    @abstractmethod
    def gaps_at(self, positions: Floats) -> Floats:
        """Gaps (k, 2) as `compute_gaps` finds them, in an array of their own, gaps of the start counted in full."""

    @abstractmethod
    def compute_start_normals(self, positions: Floats, memory: Floats) -> None:
        """Normals of the present conditions at `positions`, where the step starts (friction only)."""

    def find_near(self, slave: Floats, master: Floats) -> Near:
        """Make the near list anew, for these positions of the surfaces (m, 2)."""
        began = perf_counter()
        self.near, self._view = Near.of(self.slave, self.master, slave, master, self.size), None
        self.search_s += perf_counter() - began
        return self.near

    def restore(self, slave: Floats, master: Floats) -> None:
        """Go on with the near list that was made at these positions (m, 2); conditions are not those of a step."""
        self.find_near(slave, master)
        self.evaluated = False

    def seen(self, memory: Floats) -> ContactView:
        """What the algorithm sees at the present positions; the same object as long as its parts are the same."""
        view = self._view
        if view is None or view.memory is not memory:
            assert self.near is not None
            near = self.near.candidates
            self._view = view = ContactView(self.slave, self.master, self.at, near, REACH * self.size, memory)
        return view

    def _start(self, positions: Floats, memory: Floats) -> ContactView:
        """What the algorithm sees at the start of the step, with friction."""
        assert self.sliding is not None
        began = self.sliding.began
        take(positions, self.slave.nodes, began.slave)
        take(positions, self.master.nodes, began.master)
        return self.sliding.view(self.seen(memory))

    @property
    def start_distance(self) -> Floats | None:
        """Distances (k,) [mm] of the start that count as gaps of zero; None where they count in full."""
        start = self.start_gaps
        return start.value if start is not None and start.lasting else None

    @property
    def pushes_overlaps_out(self) -> bool:
        """Whether overlaps of the start are pushed out, so that contact puts energy in on purpose."""
        return self.start_gaps is not None and self.start_gaps.ramped

    def _take_start_gaps(self, gaps: Floats) -> None:
        """Take from the normal gaps (k, 2) [mm] what does not count."""
        if self.start_gaps is not None and (share := self.start_gaps.uncounted()) != 0.0:
            gaps[:, 0] -= share * self.start_gaps.value

    # --- from conditions to rows ----------------------------------------------------------------

    def append_factored(self, out: FactoredRows) -> bool:
        """Append all conditions to `out`; False where it is too small. Only where the kind is `factored`."""
        raise NotImplementedError(f"{type(self).__name__} gives no factored rows")

    @abstractmethod
    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`.

        Returns the next free entry, or -1 where `out` is too small. `current` (N, 2) are the
        positions at the start of the step, used with friction.
        """

    def write_bounds(self, out: Rows, first: int, last: int) -> None:
        """Friction bounds of the rows first ... last - 1."""
        assert self.sliding is not None
        slots = out.slot[first:last] - self.first_slot if self.sliding.varies else _ALL
        out.bound[:, first:last] = self.sliding.of(slots)

    def _append_slips(self, out: Rows, first: int, last: int, current: Floats) -> None:
        """Friction bounds and slips of the rows first ... last - 1, which have their tangent weights."""
        if self.sliding is not None:
            self.write_bounds(out, first, last)
            measured = self.gaps, self.normals, self.sliding.before
            rows.write_slips(first, last, self.first_slot, measured, current, out.packed.address)
        elif len(out.slip):
            out.bound[:, first:last] = 0.0
            out.slip[first:last] = 0.0

    # --- from multipliers to pressures ----------------------------------------------------------

    @abstractmethod
    def tractions(self, forces: Floats) -> Floats:
        """Lambda (k,) [MPa] from nodal forces y (k,) [N]."""

    def snapshot(self, state: State, position: Floats) -> ContactSnapshot:
        """The pair at the accepted step that ends at `position` (N, 2), with the multipliers of the state.

        Conditions are those that the step was made with; nothing is changed. Only where no step has been accepted,
        at the start of a run, after a restart or a step that failed, they are made at `position`.
        """
        if not self.evaluated:
            memory = np.zeros((self.method.memory_size, len(self.slave.nodes)))
            if self.method.memory_size:
                memory[:] = state[f"memory.{self.name}"]
            self.update(position, memory)
            self.evaluated = True
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
            forces=forces,
            tractions=np.stack([self.tractions(force) for force in forces]),
        )


def shown(passes: tuple[ContactPair, ...]) -> tuple[ContactPair, ...]:
    """The pairs that reports show: one for each contact of the scene."""
    return tuple(pair for pair in passes if not pair.second)


def initial_gaps(pair: ContactPair, positions: Floats) -> Floats:
    """Gaps (k,) [mm] as the algorithm measures them at `positions`; `FAR` where it sets no condition."""
    pair.update(positions, np.zeros((pair.method.memory_size, len(pair.slave.nodes))))
    return np.asarray(pair.gaps[:, 0].copy())


def start_distances(pair: ContactPair, positions: Floats) -> Floats:
    """`initial_gaps`, and for a multiplier without a condition the distance that another one of its node has.

    A node at the end of a chain is held by one of its multipliers or by the other, as one side ends before the other.
    """
    by_node = initial_gaps(pair, positions).reshape(pair.rows_per_node, -1)
    nearest = by_node[np.abs(by_node).argmin(axis=0), np.arange(by_node.shape[1])]
    return np.where(by_node < FAR, by_node, nearest).ravel()
