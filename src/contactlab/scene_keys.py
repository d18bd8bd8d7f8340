"""The tables of a scene file: every key with its type, default, bounds, unit and meaning.

A new key is one line here; reading, checking, defaults and writing follow from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from contactlab.fields import PartSpec, key, part

Vector = tuple[float, float]


@dataclass(frozen=True)
class Time:
    """`[time]`: how long a run lasts and in which steps."""

    end: float | Literal["auto"] = key(
        "auto", unit="s", above=0.0, says="duration; auto: loaded as slowly as needed, then held until it settles"
    )
    step: float | None = key(None, unit="s", above=0.0, says="fixed step; not written: a fraction of the stable one")
    fraction: float = key(0.9, above=0.0, most=1.0, says="step as a fraction of the stable step; unused beside `step`")
    ramp: float | None = key(
        None,
        unit="s",
        least=0.0,
        says="duration of ramps that give none themselves; not written: all of the run, or found",
    )
    hold: float | None = key(
        None,
        unit="s",
        least=0.0,
        says="with auto, time after the ramp; not written: until it settles, at most one ramp",
    )
    damping: float | None = key(
        None, unit="1/s", least=0.0, says="mass-proportional damping; not written: none, or with auto found"
    )


@dataclass(frozen=True)
class Body:
    """`[bodies.NAME]`: one mesh of one element and one material."""

    element: PartSpec = part("element", says="shape functions and quadrature")
    material: str = key(says="name of a table under [materials]")
    mesh: PartSpec = part("mesh", says="nodes, cells and named edge sets")
    velocity: Vector = key((0.0, 0.0), unit="mm/s", says="initial velocity")
    rotate: float = key(0.0, unit="degree", says="the mesh is turned about the origin by this, before the shift")
    shift: Vector = key((0.0, 0.0), unit="mm", says="the mesh is moved by this before the run: an initial gap")


@dataclass(frozen=True, kw_only=True)
class Contact:
    """`[[contacts]]`: two edge sets that must not overlap."""

    name: str | None = key(None, says="a further way to reach the contact: contacts.NAME")
    slave: str = key(says='"body.edge_set" that carries the multipliers')
    master: str = key(says='"body.edge_set" on the other side')
    algorithm: PartSpec = part("contact", says="how the gap is measured")
    swap: bool = key(False, says="exchange slave and master")
    friction: PartSpec | None = part("friction", None, says="friction law; not written: no tangential work at all")
    enforcement: PartSpec | None = part(
        "enforcement", None, says="how gap conditions become forces; not written: the integrator's own"
    )

    @property
    def sides(self) -> tuple[str, str]:
        """Slave and master as they act, `swap` taken into account."""
        return (self.master, self.slave) if self.swap else (self.slave, self.master)


@dataclass(frozen=True)
class Ramp:
    """A displacement that changes in time: `{ ramp = ..., to = ... }`."""

    ramp: Literal["parabola", "linear", "constant"] = key(
        says="parabola: at rest at both ends; linear: at constant speed; constant: at once"
    )
    to: float = key(unit="mm", says="displacement at the end of the ramp")
    duration: float | None = key(None, unit="s", above=0.0, says="not written: the ramp time of [time]")


@dataclass(frozen=True, kw_only=True)
class Support:
    """`[[supports]]`: prescribed displacements of an edge set or of a whole body."""

    name: str | None = key(None, says="a further way to reach the support: supports.NAME")
    on: str = key(says='"body.edge_set", or "body" for all its nodes')
    ux: float | Ramp | None = key(None, unit="mm", says="displacement along x; not written: free")
    uy: float | Ramp | None = key(None, unit="mm", says="displacement along y; not written: free")


@dataclass(frozen=True)
class Record:
    """`[record]`: what is kept of a run."""

    frames: int = key(50, least=1, says="stored frames, evenly spaced over the run, the last one at its end")
    recorders: tuple[PartSpec, ...] | None = part(
        "recorder", None, says="what writes to the results folder beside the small text files; not written: the usual ones"
    )
