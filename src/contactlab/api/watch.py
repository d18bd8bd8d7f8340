"""Watches (callbacks): they observe every step of a run and keep numbers of it in arrays that a restart restores."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Protocol

from contactlab.api.arrays import Floats, Ints

Memory = dict[str, Floats]
"""Arrays by name, whose shapes never change during the run."""


class StepView(Protocol):
    """The state after an accepted step; arrays are read-only.

    time, dt        [s] reached, and the length of the step
    step            accepted steps so far
    sweeps, iterations  of the contact solve and of Newton's method in this step
    reference, position  (N, 2) [mm] of all nodes
    mass            (N,) lumped [t]; zeros in statics
    bodies          their names
    contacts        number of contact pairs
    """

    time: float
    dt: float
    step: int
    sweeps: int
    iterations: int
    reference: Floats
    position: Floats
    mass: Floats
    bodies: tuple[str, ...]
    contacts: int

    def field(self, name: str) -> Floats:
        """Return a field of the state: "displacement", "velocity", "internal_force", "contact_force", "work" ..."""
        ...

    def nodes(self, body: str) -> slice:
        """Return the nodes of a body. Raises KeyError if there is no such body."""
        ...

    def slave(self, contact: int = 0) -> Ints:
        """Return global numbers of the slave nodes, in chain order."""
        ...

    def master(self, contact: int = 0) -> Ints:
        """Return global numbers of the master nodes, in chain order."""
        ...

    def segment(self, contact: int = 0) -> float:
        """Return the length of the slave's segments [mm]: the median."""
        ...

    def normal_forces(self, contact: int = 0) -> Floats:
        """Return nodal contact forces y_n [N], one per multiplier."""
        ...

    def slips(self, contact: int = 0) -> Floats:
        """Return tangential motion [mm] in this step per multiplier; zero if no master is within the search distance.

        Only in explicit runs with friction. Raises LookupError in others.
        """
        ...

    def external_force(self) -> Floats:
        """Nodal forces (N, 2) [N] of loads and effects at `time`."""
        ...

    def kinetic_energy(self) -> float:
        """Kinetic energy 1/2 v M v [mJ]."""
        ...

    def stored_energy(self) -> float:
        """Energy [mJ] stored in bodies, NaN if a law has none, and in surfaces under pressure laws and potentials."""
        ...


class Watch(ABC):
    """Observes every accepted step. Subclasses are frozen dataclasses; their fields are their keys.

    1. `begin` gives the memory before the first step: arrays whose shapes never change.
    2. `step` is called after each accepted step and writes to this memory in place, and to nothing else.
    3. The memory at the end of the run is found in `Record.watched`.

    Costs are never measured on a watched run.
    """

    @abstractmethod
    def begin(self, view: StepView) -> Memory:
        """Return the memory before the first step; `view` shows the initial state."""

    @abstractmethod
    def step(self, view: StepView, memory: Memory) -> None:
        """Observe the model after one accepted step, and keep numbers of it."""

    def end(self, memory: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """Return the part of the memory that goes into the record: all of it by default."""
        return memory
