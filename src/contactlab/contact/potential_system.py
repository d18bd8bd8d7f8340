"""All contact pairs of a model for implicit integrators, of which some have forces from an energy."""

from __future__ import annotations

from functools import cached_property
from time import perf_counter
from typing import ClassVar

from contactlab.api import ContactDerivatives, Floats, Ints
from contactlab.contact.implicit_system import ImplicitContactSystem
from contactlab.contact.potential_pair import PotentialPair


class PotentialSystem(ImplicitContactSystem):
    """`ImplicitContactSystem` with `potentials`, which set no constraints."""

    by_energy: ClassVar[bool] = True

    @cached_property
    def potentials(self) -> tuple[PotentialPair, ...]:
        """Pairs whose forces come from an energy."""
        return tuple(pair for pair in self.passes if isinstance(pair, PotentialPair))

    @property
    def stored_since_start(self) -> float:
        """Energy [mJ] of the potentials beyond their energy at the start."""
        return sum(pair.stored_since_start() for pair in self.potentials)

    def begin_step(self, position: Floats, time: float) -> None:
        """Begin a step as every system, and of the potentials."""
        for pair in self.potentials:
            pair.begin_step(position, (time - self.state.time) / self.tenth)
            # forces that the last step wrote for reports belong to no constraint
            self.multipliers[:, pair.own] = 0.0
        super().begin_step(position, time)

    def accept(self) -> None:
        """Accept the last evaluation, and write forces of the potentials for reports."""
        for pair in self.potentials:
            pair.accept(self.multipliers)
        super().accept()

    def evaluate(self, position: Floats) -> None:
        """Fill `conditions`, and compute forces of the potentials."""
        super().evaluate(position)
        began = perf_counter()
        for pair in self.potentials:
            pair.evaluate(position)
        self.seconds += perf_counter() - began

    def _add_forces(self, normal: Floats, tangential: Floats) -> None:
        for pair in self.potentials:
            pair.add_forces(normal, tangential)
        super()._add_forces(normal, tangential)

    def free_share(self, position: Floats, motion: Floats, depth: float) -> float:
        """Return the share of a motion without passage of surfaces that all potentials allow."""
        share = super().free_share(position, motion, depth)
        return min(share, *(pair.free_share(position, motion) for pair in self.potentials))

    def settled(self) -> bool:
        """True if friction of potentials, too, belongs to the end of the step."""
        taken = sum(pair.take_over() for pair in self.potentials)
        return super().settled() and taken == 0

    def dissipation(self) -> float:
        """Return the energy [mJ] dissipated by friction in the step."""
        return super().dissipation() + sum(pair.dissipation() for pair in self.potentials)

    def friction_along_the_way(self) -> tuple[float, float]:
        """Return friction energy [mJ] of a load step, and its excess, which potentials have none of."""
        taken, excess = super().friction_along_the_way()
        return taken + sum(pair.dissipation() for pair in self.potentials), excess

    def linearise(self, chosen: Ints) -> ContactDerivatives:
        """Return derivatives of the chosen slots, and of all forces."""
        found = super().linearise(chosen)
        began, change = perf_counter(), found.force
        for pair in self.potentials:
            change = change + pair.force_derivative(2 * len(self.start))
        self.seconds += perf_counter() - began
        return found._replace(force=change)
