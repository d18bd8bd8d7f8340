"""One contact pair whose algorithm gives operators: search, pieces, coupling, rows, and back to pressures."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlab.api import ContactAlgorithm, FactoredRows, Floats, FrictionLaw, Ints, Pieces, Rows, Surface
from contactlab.api.arrays import Flags
from contactlab.api.surface import SurfacePositions
from contactlab.contact.coupling import Coupling
from contactlab.contact.examination import copies, refuse_written
from contactlab.contact.near_list import SKIN, Near
from contactlab.contact.operator_arrays import OperatorArrays
from contactlab.contact.pair import ContactPair
from contactlab.errors import SceneError, WrongAnswer
from contactlab.kernels.contact import pair as kernels
from contactlab.kernels.contact import rows
from contactlab.kernels.contact.factored_rows import FAR
from contactlab.kernels.contact.tables import WeightsTable


class OperatorPair(ContactPair):
    """A slave and a master surface under one `ContactAlgorithm`.

    count  number of pieces of the last `update`
    """

    factored = True

    def __init__(
        self,
        name: str,
        algorithm: ContactAlgorithm,
        slave: Surface,
        master: Surface,
        reference: Floats,
        first_slot: int,
        friction: FrictionLaw | None,
        fixed: Flags,
    ) -> None:
        algorithm = algorithm if friction is None else algorithm.with_friction()
        super().__init__(name, algorithm, slave, master, reference, first_slot, friction)
        self.algorithm, self.count = algorithm, 0
        coupling = Coupling(slave, algorithm.rows_per_node, algorithm.carriers(slave), fixed, algorithm.merged_below)
        self.arrays = OperatorArrays(slave, master, self.at, self.gaps, _widths(algorithm, slave, master), coupling)
        self.skin = SKIN * self.size
        self._unchecked = True

    @property
    def pieces(self) -> Pieces:
        """Segment contributions, `count` of them of the last `update`."""
        return self.arrays.pieces

    @property
    def coupling(self) -> Coupling:
        """The factorised T of the last `update`."""
        return self.arrays.coupling

    @property
    def separation(self) -> Floats:
        """Weighted positions of the slave minus those of the master (k, 2) [mm], where they were last measured."""
        return self.arrays.separation

    @property
    def normals(self) -> Floats:
        """Unit vectors (k, 2) of all multipliers, from the master towards the slave, of the last `update`."""
        return self.arrays.pieces.normal

    @property
    def between(self) -> tuple[Ints, Ints, Ints]:
        """Slave nodes that carry no multiplier, and the carriers that follow and precede each."""
        return self.coupling.between(len(self.slave.nodes))

    @property
    def cover(self) -> Floats:
        """Covered length (k,) [mm] of each multiplier, of the last `update`."""
        return self.arrays.coupling.cover

    @property
    def full(self) -> Floats:
        """Length (k,) [mm] of each multiplier on full cover."""
        return self.arrays.coupling.full

    def weights(self) -> WeightsTable:
        """Weights of both sides' nodes in each condition of the last update, made when they are first asked for."""
        return self.arrays.weights()

    @property
    def rows_address(self) -> int:
        """Where kernels find the arrays of this pair, `weights` up to date."""
        self.arrays.weights()
        return self.arrays.address

    def calls_per_step(self) -> dict[str, int]:
        """Pieces once, normals at the start of the step once with friction."""
        return {"contact pieces": 1, "contact normals": int(self.friction is not None)}

    # --- from positions to coupling -------------------------------------------------------------

    def update(self, positions: Floats, memory: Floats) -> None:
        """Search, integrate and factorise at `positions` (N, 2)."""
        self._make(positions, positions, positions, memory, kernels.AT | kernels.MEASURED)

    def update_pushed(self, predicted: Floats, compliance: Floats, force: Floats, memory: Floats) -> None:
        """`update` at predicted + compliance * force, all (N, 2), and `compute_gaps` at `predicted`."""
        self._make(predicted, compliance, force, memory, kernels.AT | kernels.MEASURED | kernels.PUSHED)

    def _make(self, positions: Floats, compliance: Floats, force: Floats, memory: Floats, asked: int) -> None:
        if not kernels.place(self.arrays.address, positions, compliance, force, asked) <= self.skin:
            self.find_near(self.at.slave, self.at.master)
        pieces = self.arrays.pieces
        view = self.seen(memory)
        before = copies(view) if self._unchecked else {}
        count = self.algorithm.pieces(view, pieces)
        if before:
            refuse_written(view, before, self.algorithm, "pieces")
        if before or type(count) is not int or not 0 <= count <= len(pieces.slave):
            self._check(count)
        self.count = count
        self._join()
        if self.smooth is not None:
            self.smooth.update(memory)
            self.smooth.add(self.arrays.measured, self.gaps)
        self._take_start_gaps(self.gaps)

    def _check(self, count: Any) -> None:
        """Raise WrongAnswer for pieces that point outside the arrays, which compiled code would follow."""
        refuse_wrong(self.pieces, count, len(self.slave.nodes), len(self.master.nodes), type(self.algorithm).__name__)
        self._unchecked = False

    def _join(self) -> None:
        """Coupling, columns (widened as needed) and gaps of the pieces."""
        while True:
            kept, lacking, missing = kernels.join(self.arrays.address, self.count, self.slave.edges.shape[1] == 2)
            if kept < 0:
                raise SceneError(
                    "the slave is a closed curve that is covered all around: its conditions are coupled without an end",
                    where=f"{self.name}.slave",
                    got=f"a closed chain of {len(self.slave.segments)} segments",
                    allowed="an open slave, or an algorithm whose conditions are not coupled (node-on-segment)",
                    hint='write algorithm = "node-on-segment", or cut the edge set in two under [bodies.NAME.sets] and '
                    "declare a contact for each half; to swap the sides helps only where the other one is open",
                )
            if not lacking and not missing:
                break
            self.arrays.widen(lacking, missing)
        self.arrays.joined()

    def compute_gaps(self, positions: Floats) -> None:
        """Separations and gaps of all kept multipliers at `positions`, with the rows of the last `update`."""
        kernels.place(self.arrays.address, positions, positions, positions, kernels.MEASURED)
        kernels.compute_gaps(self.arrays.address)
        if self.smooth is not None:
            self.smooth.add(self.arrays.measured, self.gaps)
        self._take_start_gaps(self.gaps)

    def gaps_at(self, positions: Floats) -> Floats:
        """Gaps (k, 2) at `positions` with the rows of the last `update`, in an array of their own."""
        at = SurfacePositions(positions[self.slave.nodes], positions[self.master.nodes])
        separation, gaps = np.zeros((self.slots, 2)), np.zeros((self.slots, 2))
        self.separations(at, self.normals, separation, gaps)
        if self.smooth is not None:
            self.smooth.add(at, gaps)
        return gaps

    def separations(self, at: SurfacePositions, normals: Floats, separation: Floats, gaps: Floats) -> None:
        """Separations (k, 2) and gaps (k, 2) of surfaces at `at`, with the coupling of the last `update`."""
        kernels.compute_gaps_at(self.arrays.address, at, normals, separation, gaps)

    def compute_start_normals(self, positions: Floats, memory: Floats) -> None:
        """Normals of the present pieces at `positions`, where the step starts (friction only)."""
        assert self.sliding is not None
        self.algorithm.normals(self._start(positions, memory), self.pieces, self.count, self.sliding.before)

    def find_near(self, slave: Floats, master: Floats) -> Near:
        """Make the near list anew, for these positions of the surfaces (m, 2)."""
        near = super().find_near(slave, master)
        self.arrays.use(near, self.algorithm.capacity(self.slave, near.candidates))
        self._unchecked = True
        return near

    # --- from coupling to rows ------------------------------------------------------------------

    def append_factored(self, out: FactoredRows) -> bool:
        """Append all conditions to `out`; False where it is too small."""
        count = kernels.append_factored(self.arrays.address, self.first_slot, out.count, out.packed.address)
        if count >= 0:
            out.count = count
        return bool(count >= 0)

    def append_rows(self, out: Rows, entries: int, margin: float, multipliers: Floats, current: Floats) -> int:
        """Append rows with a gap below `margin` [mm] or a force to `out`."""
        if self.everywhere:
            margin = FAR
        first = out.count
        count, end = rows.write_rows(
            self.rows_address, min(margin, FAR), multipliers, self.first_slot, first, entries, out.packed.address
        )
        if count < 0:
            return -1
        self._append_slips(out, first, count, current)
        out.count = count
        return int(end)

    # --- from multipliers to pressures ----------------------------------------------------------

    def tractions(self, forces: Floats) -> Floats:
        """Lambda (k,) [MPa] from nodal forces y (k,) [N]: T^-1 y, the owner's value where merged, 0 off cover."""
        return self.coupling.solve(forces)


def _widths(algorithm: ContactAlgorithm, slave: Surface, master: Surface) -> tuple[int, int, int]:
    widths = algorithm.widths(slave, master)
    if np.shape(widths) != (3,) or min(widths) < 1:
        raise WrongAnswer(
            f"{type(algorithm).__name__}: widths gave {widths}, needed: how many slave nodes, multipliers and "
            "master nodes a piece couples"
        )
    return widths


def refuse_wrong(pieces: Pieces, count: Any, slave_nodes: int, master_nodes: int, part: str) -> None:
    """Raise WrongAnswer where the first `count` pieces of a part are not as the contract says."""
    room = len(pieces.slave)
    if not isinstance(count, int | np.integer) or not 0 <= count <= room:
        raise WrongAnswer(
            f"{part}: pieces gave {count}, needed: how many of the {room} pieces of its capacity are filled"
        )
    sides = {"slave": slave_nodes, "multiplier": len(pieces.normal), "master": master_nodes}
    for name, size in sides.items():
        used = getattr(pieces, name)[:count]
        if used.size and not 0 <= used.min() <= used.max() < size:
            wrong = used.min() if used.min() < 0 else used.max()
            raise WrongAnswer(f"{part}: pieces filled {name} with {wrong}, needed: positions 0 to {size - 1}")
