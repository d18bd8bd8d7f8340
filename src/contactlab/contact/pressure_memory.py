"""Numbers in addition to the gap that a pressure law declares: its memory, and time, place and slip if needed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats, Ints, NormalLaw, State
from contactlab.contact.pair import ContactPair
from contactlab.parts.remembered import remember


class PressureMemory:
    """Keyword arguments of a law, for the k multipliers of all contacts.

    kept    (r, k) memory and, if needed, the rate of slip [mm/s] of the last step: a part of the state
    points  undeformed positions (k, 2) [mm] of the slave nodes
    fields  functions of time [s] that give fields (k,) of the scene
    """

    def __init__(self, law: NormalLaw, pairs: tuple[ContactPair, ...], state: State, reference: Floats) -> None:
        self.law, self.kept = law, state["pressure_law"]
        self.rows = dict(zip(kept_by(law), self.kept, strict=True))
        nodes = np.concatenate([np.tile(pair.slave.nodes, pair.rows_per_node) for pair in pairs])
        self.points = reference[nodes]
        self.fields: Mapping[str, Callable[[float], Any]] = {}
        self.time = self.dt = 0.0
        remember(law, "start", law.start(), self.rows)
        for pair in pairs:
            known = {name: self.rows[name][pair.own] for name in law.memory}
            pair.memory.update({f"pressure.{name}" if name in pair.memory else name: v for name, v in known.items()})

    def begin_step(self, time: float, dt: float) -> None:
        """Set the time [s] of the gaps, in a step of `dt` [s]."""
        self.time, self.dt = time, dt

    def of(self, slots: Ints | slice) -> dict[str, Any]:
        """Return keywords of the law for some multipliers."""
        found: dict[str, Any] = {name: values[slots] for name, values in self.rows.items()}
        found |= {
            name: np.broadcast_to(value(self.time), len(self.points))[slots] for name, value in self.fields.items()
        }
        given = {"time": self.time, "dt": self.dt, "position": self.points[slots]}
        return found | {name: given[name] for name in self.law.needs if name in given}

    def accept(self, gap: Floats, stiffness: Floats, size: Floats, slip: Floats | None) -> None:
        """Update the memory after an accepted step with gaps (k,) [mm] and, with friction, slips (k,) [mm] in it."""
        pressure, slope = np.zeros_like(gap), np.zeros_like(gap)
        gap = np.minimum(gap, self.law.begins())
        self.law.pressure(gap, stiffness, size, pressure, slope, **self.of(slice(None)))
        if "slip_rate" in self.rows and slip is not None:
            self.rows["slip_rate"][:] = np.where(pressure > 0.0, slip / self.dt, 0.0)
        known = {name: np.copy(values) for name, values in self.of(slice(None)).items()}
        beside = {"gap": gap, "pressure": pressure, "stiffness": stiffness, "size": size}
        remember(self.law, "evolve", self.law.evolve(**beside, **known), self.rows)


def kept_by(law: NormalLaw) -> tuple[str, ...]:
    """Return rows of the state of a law, by name."""
    return (*(("slip_rate",) if "slip_rate" in law.needs else ()), *law.memory)


def named(memory: PressureMemory | None, slots: Ints | slice) -> dict[str, Any]:
    """Return keywords of a law for some multipliers: none for a law of the gap alone."""
    return {} if memory is None else memory.of(slots)
