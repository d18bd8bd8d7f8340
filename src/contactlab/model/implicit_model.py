"""The model for implicit integrators: trials that may be undone, and the stiffness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from contactlab.api import Estimate, Floats, ImplicitIntegrator
from contactlab.kernels.checks import smallest_jacobian
from contactlab.model.bodies.tangent import Tangent
from contactlab.model.examination import examine_bodies, examine_effects
from contactlab.model.model import Model

if TYPE_CHECKING:
    from contactlab.contact.implicit_system import ImplicitContactSystem

SAME = 1e-9  # of the ramp: times that differ by less are equal


@dataclass
class ImplicitModel(Model):
    """Implements `contactlab.api.ImplicitEquations`.

    estimates    states expected at later times, from a coarser mesh
    listening    called after each iteration; None if nothing records it
    stiffness_s  part of `seconds` spent on stiffness matrices
    """

    contact: ImplicitContactSystem | None
    integrator: ImplicitIntegrator

    explicit: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.contact is not None:
            self.contact.tenth = 0.1 * self.timing.last
        self.estimates: Sequence[Estimate] = ()
        self.stabilised = False
        self._start, self._share = self.state["displacement"].copy(), 1.0
        self._tangent: Tangent | None = None
        self.stiffness_s = 0.0
        self.listening: Callable[[], None] | None = None
        self._add_load_stiffness: Callable[[float, float, float, Floats], None] | None = None
        self._derivatives = [
            np.ascontiguousarray(body.element.shape(body.element.quadrature().points).gradient) for body in self.bodies
        ]

    @property
    def quasi_static(self) -> bool:
        """See `contactlab.api.ImplicitEquations`."""
        return self.timing.end is None

    def internal_force(self, dt: float, share: float = 1.0) -> None:
        """See `contactlab.api.ImplicitEquations`; a component with a result that is not finite is named immediately."""
        self._share = share
        with self._part_of_the_way():
            super().internal_force(dt)
            if not np.isfinite(self.state["internal_force"].sum()):
                examine_bodies(self)

    @contextmanager
    def _part_of_the_way(self) -> Iterator[None]:
        """Move displacements and positions to the evaluation point of stresses, and back to the trial."""
        if self._share == 1.0:
            yield
            return
        u = self.state["displacement"]
        end = u.copy()
        np.add(self._start, self._share * (end - self._start), out=u)
        np.add(self.reference, u, out=self.position)
        try:
            yield
        finally:
            u[:] = end
            np.add(self.reference, u, out=self.position)

    def external_force(self, time: float, out: Floats) -> bool:
        """Fill all loads as `Model` does; an effect with a result that is not finite is named immediately."""
        loaded = super().external_force(time, out)
        if loaded and not np.isfinite(out.sum()):
            examine_effects(self, time)
        return loaded

    def begin_step(self, dt: float) -> None:
        """Begin a step of length dt [s] at the present state; dt = 0 puts everything back after a rejected step."""
        np.add(self.reference, self.state["displacement"], out=self.position)
        self._start[:] = self.state["displacement"]
        for forces in self.forces:
            forces.begin_step()
        if self.contact is not None:
            self.contact.begin_step(self.position, self.state.time + dt)
        if dt == 0.0:
            self.make_constraints()

    def _follow(self, dt: float) -> None:
        if self.increment is not None:
            np.subtract(self.state["displacement"], self._start, out=self.increment)

    def lagging_work(self) -> float:
        """Return 0: velocities and positions belong to the same time."""
        return 0.0

    def stiffness(self, dt: float) -> Any:
        """Return the assembled stiffness at the last `internal_force`; see `contactlab.api.ImplicitEquations`."""
        began = perf_counter()
        if self._tangent is None:
            self._tangent = Tangent(len(self.reference), self.forces)
        with self._part_of_the_way():
            matrix = self._tangent.assemble(dt)
        spent = perf_counter() - began
        self.seconds, self.stiffness_s = self.seconds + spent, self.stiffness_s + spent
        return matrix

    def add_load_stiffness(self, time: float, stiffness: Any, share: float, rate: float) -> None:
        """Add minus the derivative of the loads; see `contactlab.api.ImplicitEquations`."""
        if not self.loading.loads:
            return
        if self._add_load_stiffness is None:
            from contactlab.model.loading.load_stiffness import LoadStiffness

            assert self._tangent is not None
            self._add_load_stiffness = LoadStiffness(self, self._tangent.pattern.place_of).add
        self._add_load_stiffness(time, share, rate, stiffness.data)

    def estimate(self, time: float) -> Estimate | None:
        """Return the entry of `estimates` at this time; see `contactlab.api.ImplicitEquations`."""
        near = SAME * self.timing.ramp
        return next((known for known in self.estimates if abs(known.time - time) <= near), None)

    def folded(self) -> bool:
        """Return whether a cell has a point with det <= 0."""
        with self._part_of_the_way():
            return any(
                not smallest_jacobian(forces.geometry, block.connectivity, derivatives)[0] > 0.0
                for forces, derivatives in zip(self.forces, self._derivatives, strict=True)
                for block in forces.blocks
            )

    def iterated(self) -> None:
        """Record the state of the iteration; see `contactlab.api.ImplicitEquations`."""
        if self.listening is not None:
            self.listening()

    def accept(self) -> None:
        """Move history and contact memory of the trial into the state."""
        for forces in self.forces:
            forces.accept()
        if self.contact is not None:
            self.contact.accept()
