"""A contact pair whose forces are the gradient of an energy."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from scipy.sparse import coo_array

from contactlab.api import Floats, FrictionLaw, Ints, NodalForces, Potential, PotentialView, Surface
from contactlab.api.compiled.chains import nodal_normals, segment_normals
from contactlab.contact.closest import ClosestPoints
from contactlab.contact.gap_pair import GapPair
from contactlab.contact.pair import turned
from contactlab.contact.start_gaps import StartGaps
from contactlab.errors import WrongAnswer
from contactlab.kernels.contact.pair import FAR

STEP = 1e-6  # of a segment: differences of gradients
LAGGED = 1e-8  # of the largest force: friction forces have converged if newer normal forces change them less
LATER = 10.0  # times the last change: bound of all later changes
STALLED = 1e-4  # of the largest force: convergence, too, if newer normal forces no longer halve the change


class Opened(StartGaps):
    """Touching surfaces that were opened before the run; all gaps count in full."""

    def __init__(self, slots: int, opened: float) -> None:
        super().__init__(np.zeros(slots))
        self.opened = opened

    def uncounted(self) -> float:
        """Return 0: all gaps count."""
        return 0.0

    def told(self) -> str:
        """Return a message with the amount."""
        return (
            f"surfaces that touch before the run were opened by up to {self.opened:.4g} mm, as the algorithm needs; "
            "nodes of the slave were moved, and nothing is strained"
        )


class PotentialPair(GapPair):
    """A slave and a master surface under one `Potential`.

    Closest points give gaps and rows of its nodes for all reports; forces come from the potential. Multipliers are
    written once a step is accepted.

    nodes      (n,) global nodes of both surfaces, the slave's first
    view       the potential's view; `start` and `lagged` are refilled
    origin     (2,) [mm] origin of the potential's positions, sizes of the surfaces away from the model's origin:
               products of positions far from the origin would lose the digits of small distances
    at_nodes   (n, 2) [mm] positions of the last `evaluate`, from `origin`
    pushed     (n, 2) [N] gradient there; rubbed: gradient of friction, None without
    change     [N] of friction by the last update of normal forces
    kept       (n, 2) [N] gradient of friction at the end of the last step, part of the state
    slipped    (m,) [mm] slip of the slave's nodes in the last step, with friction
    """

    by_energy: ClassVar[bool] = True
    lagged: float = LATER * LAGGED

    def __init__(
        self,
        name: str,
        potential: Potential,
        sides: tuple[Surface, Surface],
        reference: Floats,
        first_slot: int,
        friction: FrictionLaw | None,
        behind: tuple[Floats, Floats],
    ) -> None:
        """Set `behind` each node (N,): the modulus [MPa] of the material, and modulus over cell depth [MPa/mm]."""
        super().__init__(name, ClosestPoints(), *sides, reference, first_slot, friction)
        self.method, self.potential = potential, potential
        self.nodes = np.concatenate([self.slave.nodes, self.master.nodes])
        self.dof = np.add.outer(2 * self.nodes, np.arange(2)).ravel()
        at = reference[self.nodes]
        size = np.ptp(at, axis=0).max()
        self.origin = np.round(at.mean(axis=0) / size) * size
        at = at - self.origin
        edges = np.concatenate([self.slave.segments, self.master.segments + len(self.slave.nodes)]).astype(np.int32)
        length = np.zeros(len(at))
        np.add.at(length, edges, 0.5 * np.hypot(*(at[edges[:, 1]] - at[edges[:, 0]]).T)[:, None])
        bound = friction.bound() if friction is not None else None
        modulus, stiffness = (values[self.nodes] for values in behind)
        self.view = PotentialView(*sides, edges, at, length, modulus, stiffness, at.copy(), at.copy(), bound)
        self.position, self.at_nodes, self.pushed = reference, at.copy(), np.zeros_like(at)
        self.rubbed: Floats | None = None
        self.change = np.inf
        self.kept, self.slipped = np.zeros_like(at), np.zeros(len(self.slave.nodes))
        self.clearance = float(potential.clearance(self.view))

    def calls_per_step(self) -> dict[str, int]:
        """Count the gradient once, and the gradient of friction."""
        return {"contact potential": 1 + int(self.friction is not None)}

    def slips_at_nodes(self, slips: Floats, gaps: Floats) -> Floats:
        """Return slips (m,) [mm] of the last accepted step: no constraint has any."""
        return self.slipped

    def _own(self, position: Floats) -> Floats:
        """Return positions (n, 2) [mm] of the nodes as the potential sees them."""
        return np.asarray(position[self.nodes] - self.origin)

    # --- a trial ----------------------------------------------------------------------------------

    def begin_step(self, position: Floats, pace: float) -> None:
        """Begin a step at `position` (N, 2); for `pace` see `PotentialView`, 0 to keep the last one."""
        if pace > 0.0:
            self.view = self.view._replace(pace=min(1.0, pace))
        self.view.start[:] = self.view.lagged[:] = self._own(position)
        self.change = np.inf

    def evaluate(self, position: Floats) -> None:
        """Compute forces at trial positions (N, 2)."""
        self.position, self.at_nodes = position.copy(), self._own(position)
        self.pushed = self._checked(self.potential.gradient(self.view, self.at_nodes), "gradient")
        if self.friction is not None:
            self.rubbed = self._friction()

    def _friction(self) -> Floats:
        """Return the gradient of friction; before any motion, its value at the end of the last step."""
        if self.still:
            return np.array(self.kept)
        return self._checked(self.potential.friction_gradient(self.view, self.at_nodes), "friction_gradient")

    @property
    def still(self) -> bool:
        """Return whether nothing has moved since the step started."""
        return np.array_equal(self.at_nodes, self.view.start)

    def _checked(self, found: Any, method: str) -> Floats:
        if np.shape(found) != self.at_nodes.shape:
            raise WrongAnswer(
                f"{type(self.potential).__name__}: {method} has the shape {np.shape(found)}, needed "
                f"{self.at_nodes.shape}, one row for each node of both surfaces"
            )
        return np.asarray(found, float)

    def add_forces(self, normal: Floats, tangential: Floats) -> None:
        """Subtract the gradients from (N, 2) each."""
        np.subtract.at(normal, self.nodes, self.pushed)
        if self.rubbed is not None:
            np.subtract.at(tangential, self.nodes, self.rubbed)

    def force_derivative(self, size: int) -> Any:
        """Return the derivative (size, size) of all its forces by the degrees of freedom of the model."""
        total = self.stiffness()
        if self.friction is not None:
            rub = self.potential
            total = total + self._second(rub.friction_hessian, rub.friction_gradient, "friction_hessian")
        entries = total.tocoo()
        place = self.dof[entries.row], self.dof[entries.col]
        return coo_array((-entries.data, place), shape=(size, size)).tocsr()

    def stiffness(self) -> Any:
        """Return the second derivative (2n, 2n) of the energy by the positions of its nodes at the last `evaluate`."""
        return self._second(self.potential.hessian, self.potential.gradient, "hessian")

    def _second(self, given: Any, gradient: Any, method: str) -> Any:
        found = given(self.view, self.at_nodes)
        n = 2 * len(self.nodes)
        if found is None:
            return coo_array(differences(gradient, self.view, self.at_nodes, STEP * self.size))
        if np.shape(found) != (n, n):
            raise WrongAnswer(
                f"{type(self.potential).__name__}: {method} has the shape {np.shape(found)}, needed {(n, n)}"
            )
        return found

    def free_share(self, position: Floats, motion: Floats) -> float:
        """Return the largest fraction of a motion (N, 2) from `position` (N, 2) that the potential allows."""
        share = self.potential.largest_step(self.view, self._own(position), motion[self.nodes])
        return min(1.0, max(0.0, float(share)))

    def take_over(self) -> bool:
        """Update the normal forces of friction to the last `evaluate`. Return whether friction changes."""
        before = self.rubbed
        if before is None:
            return False
        lagged = self.view.lagged.copy()
        self.view.lagged[:] = self.at_nodes
        now = self._friction()
        change, largest = np.abs(now - before).max(initial=0.0), np.abs(self.pushed).max(initial=0.0)
        stalled = change <= STALLED * largest and change > 0.5 * self.change
        self.change = change
        if stalled or change <= LAGGED * largest:
            self.view.lagged[:] = lagged
            self.lagged = LATER * max(LAGGED, float(change / max(largest, 1e-300)))
            return False
        self.rubbed = now
        return True

    def dissipation(self) -> float:
        """Return the energy [mJ] dissipated by friction in the step."""
        if self.rubbed is None:
            return 0.0
        return float(np.vdot(self.rubbed, self.at_nodes - self.view.start))

    def creep(self, states: Ints) -> float:
        """Return mean slip of stick nodes (1 in `states`) in the last step, by friction, over the largest motion."""
        motion = float(np.hypot(*(self.at_nodes - self.view.start).T).max())
        held = np.where(states == 1, np.hypot(*self.kept[: len(states)].T), 0.0)
        return float(held @ np.abs(self.slipped)) / max(float(held.sum()) * motion, 1e-300)

    def stored_since_start(self) -> float:
        """Return the energy [mJ] of the potential at the last `evaluate` beyond the undeformed surfaces."""
        start, now = (self.potential.energy(self.view, at) for at in (self.view.reference, self.at_nodes))
        return float(now - start)

    # --- an accepted step -------------------------------------------------------------------------

    def accept(self, multipliers: Floats) -> None:
        """Write nodal forces y of the slave's nodes, from their pressures, in `multipliers` (r, slots)."""
        m, segments = len(self.slave.nodes), self.slave.segments
        self.update(self.position, np.zeros((0, m)))
        if self.sliding is not None:
            began = self.position.copy()
            began[self.nodes] = self.view.start + self.origin
            self.slipped[:] = (self.gaps - self.gaps_at(began))[:, 1]
            self.compute_start_normals(began, np.zeros((0, m)))
        if self.rubbed is not None:
            self.kept[:] = self.rubbed
        across, lengths, normal = np.zeros((len(segments), 2)), np.zeros(len(segments)), np.zeros((m, 2))
        segment_normals(self.at.slave, segments, across, lengths)
        nodal_normals(self.slave.node_segments, across, lengths, normal)
        push, rub = self._shown(normal)
        if self.rubbed is not None and self.still:
            rub = -self.rubbed[:m]  # without slip the potential has no friction of its own
        pressed = (push * normal).sum(axis=1) < 0.0
        # nodes are pushed along their forces, so that these sum up to the acting force
        size = np.where(pressed, np.hypot(*push.T), 1.0)
        inward = np.where(pressed[:, None], push / size[:, None], -normal)
        along = turned(inward)
        self.normals[:] = inward
        own = slice(self.first_slot, self.first_slot + m)
        held = (self.gaps[:m, 0] < FAR) & pressed
        multipliers[0, own] = np.where(held, size, 0.0)
        if self.friction is not None:
            multipliers[1, own] = np.where(held, (rub * along).sum(axis=1), 0.0)

    def _shown(self, normal: Floats) -> NodalForces:
        m = len(normal)
        if (forces := self.potential.nodal_forces(self.view, self.at_nodes)) is not None:
            return forces
        stresses = self.potential.pressures(self.view, self.at_nodes, normal, self.full[:m])
        if stresses is None:
            return NodalForces(-self.pushed[:m], -self.rubbed[:m] if self.rubbed is not None else np.zeros((m, 2)))
        push, rub = (np.stack(stresses) * self.full[:m])[:, :, None]
        return NodalForces(-push * normal, rub * np.stack([-normal[:, 1], normal[:, 0]], axis=1))


def differences(gradient: Any, view: PotentialView, at: Floats, step: float) -> Floats:
    """Return central differences (2n, 2n) of a gradient at positions (n, 2)."""
    out = np.zeros((at.size, at.size))
    for column in range(at.size):
        pair = []
        for sign in (1.0, -1.0):
            moved = at.copy()
            moved.reshape(-1)[column] += sign * step
            pair.append(np.asarray(gradient(view, moved)).ravel())
        out[:, column] = (pair[0] - pair[1]) / (2.0 * step)
    return out
