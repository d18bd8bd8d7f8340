"""Incremental potential contact, an adapter to the IPC Toolkit (`ipctk`).

Nodes of either side that are closer than a distance dhat to the other side repel it with the energy of a barrier that
grows without bound as they touch (Li et al. 2020), weighted by lengths so that it converges under refinement (Li et al.
2023). No correction may go through the other side, by continuous collision detection. Theory: docs/theory/barrier.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from contactlab.api import Floats, Potential, PotentialView

KEPT = 0.2  # of a distance, after a correction: if surfaces nearly meet, forces are too large to be of use


@dataclass(frozen=True)
class Barrier(Potential):
    """Surfaces repel each other within a short distance and never intersect.

    dhat       [-] distance at which it begins, over the shortest undeformed segment of both surfaces
    stiffness  [-] pressure scale of the barrier over the modulus of the softer side: a pressure p closes about
               sqrt(p / (24 stiffness modulus)) of dhat
    slip       [-] slip over dhat up to which friction grows to its bound, in a step of a tenth of the loading or time
    """

    dhat: float = 0.05
    stiffness: float = 1.0
    slip: float = 0.01

    passes_patch_test: ClassVar[bool] = False
    rubs: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for name, most in (("dhat", 0.5), ("stiffness", np.inf), ("slip", np.inf)):
            value = getattr(self, name)
            if not 0.0 < value <= most or not np.isfinite(value):
                raise ValueError(f"{name}: got {value}, allowed: above 0" + (f", up to {most}" if most < 1 else ""))
        _toolkit()

    def clearance(self, view: PotentialView) -> float:
        """The distance dhat [mm]."""
        ends = view.reference[view.edges]
        return self.dhat * float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).min())

    def energy(self, view: PotentialView, positions: Floats) -> float:
        """Energy of the barrier; inf if surfaces intersect."""
        mesh = _mesh(view)
        if _toolkit().has_intersections(mesh, positions):
            return float("inf")
        return float(self._barrier(view)(self._collisions(view, positions), mesh, positions))

    def gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Gradient of the energy."""
        found = self._barrier(view).gradient(self._collisions(view, positions), _mesh(view), positions)
        return np.asarray(found).reshape(-1, 2)

    def hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Exact Hessian of the energy, not projected."""
        return self._barrier(view).hessian(self._collisions(view, positions), _mesh(view), positions)

    def largest_step(self, view: PotentialView, positions: Floats, displacement: Floats) -> float:
        """The fraction that leaves `KEPT` of distances, by additive continuous collision detection."""
        beyond = positions + displacement / (1.0 - KEPT)  # what would touch there has lost so much on its way
        rule = _toolkit().AdditiveCCD(conservative_rescaling=0.9)
        return float(_toolkit().compute_collision_free_stepsize(_mesh(view), positions, beyond, narrow_phase_ccd=rule))

    def friction_gradient(self, view: PotentialView, positions: Floats) -> Floats:
        """Smoothed Coulomb friction, from normal forces and contact points at the lagged positions."""
        potential, rubbing = self._rubbing(view)
        found = potential.gradient(rubbing, _mesh(view), positions - view.start)
        return np.asarray(found).reshape(-1, 2)

    def friction_hessian(self, view: PotentialView, positions: Floats) -> Any:
        """Derivative of friction by the slip."""
        potential, rubbing = self._rubbing(view)
        return potential.hessian(rubbing, _mesh(view), positions - view.start)

    def _barrier(self, view: PotentialView) -> Any:
        m = len(view.slave.nodes)
        pressure = self.stiffness * float(min(view.modulus[:m].min(), view.modulus[m:].min()))
        return _toolkit().BarrierPotential(self.clearance(view), pressure, use_physical_barrier=True)

    def _collisions(self, view: PotentialView, positions: Floats) -> Any:
        ipctk = _toolkit()
        found = ipctk.NormalCollisions()
        found.use_area_weighting = True
        found.collision_set_type = ipctk.NormalCollisions.IMPROVED_MAX_APPROX
        found.build(_mesh(view), positions, self.clearance(view))
        return found

    def _rubbing(self, view: PotentialView) -> tuple[Any, Any]:
        ipctk, bound = _toolkit(), view.friction
        assert bound is not None  # the core calls this only with friction
        found = ipctk.TangentialCollisions()
        collisions = self._collisions(view, view.lagged)
        found.build(_mesh(view), view.lagged, collisions, self._barrier(view), bound.coefficient)
        return ipctk.FrictionPotential(view.pace * self.slip * self.clearance(view)), found


@lru_cache
def _toolkit() -> Any:
    """The library, silent and with one thread: sums over more would differ in their last digits."""
    try:
        import ipctk
    except ImportError as error:
        raise ValueError(f"the barrier needs the IPC Toolkit: pip install ipctk ({error})") from error
    ipctk.set_logger_level(ipctk.off)
    ipctk.set_num_threads(1)
    return ipctk


def _mesh(view: PotentialView) -> Any:
    return _made(view.reference.tobytes(), view.edges.tobytes(), len(view.slave.nodes))


@lru_cache(maxsize=16)
def _made(reference: bytes, edges: bytes, slaves: int) -> Any:
    """The toolkit's mesh, in which only nodes and segments of different sides collide."""
    ipctk = _toolkit()
    points = np.frombuffer(reference).reshape(-1, 2)
    mesh = ipctk.CollisionMesh(points, np.frombuffer(edges, np.int32).reshape(-1, 2))
    mesh.can_collide = ipctk.make_vertex_patches_filter((np.arange(len(points)) >= slaves).astype(np.int32))
    return mesh
