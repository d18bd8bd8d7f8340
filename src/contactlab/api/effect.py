"""Effects: nodal forces that are neither loads nor contact."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

from contactlab.api.arrays import Floats, Ints
from contactlab.api.profile import Profile


def _uniform(profile: Profile, nodes: Ints) -> Floats:
    raise ValueError("profile: got one, allowed: none without a scene")


class EffectView(NamedTuple):
    """All data that an effect sees. Arrays are read-only and always current.

    reference     (N, 2) undeformed positions [mm]
    mass          (N,) lumped [t]; 0 for nodes of rigid surfaces; (0,) in statics unless an effect needs it
    displacement  (N, 2) [mm]
    velocity      (N, 2) [mm/s], half a step back in explicit runs; zero without inertia
    bodies        names of all bodies
    nodes         nodes (k,) of "body" or "body.edge_set"; a wrong name ends in an error at the effect's key `on`
    shares        nodes (k,) of bodies by name, or of edge sets, and their shares (k,) of the area, or of the length;
                  shares add up to 1
    factors       of a profile: (k,) [-] at the undeformed positions of nodes (k,)
    fields        that the effect `needs`, by name: functions of time [s] that return values (N,) at the nodes
    """

    reference: Floats
    mass: Floats
    displacement: Floats
    velocity: Floats
    bodies: tuple[str, ...]
    nodes: Callable[[str], Ints]
    shares: Callable[[Sequence[str]], tuple[Ints, Floats]]
    factors: Callable[[Profile, Ints], Floats] = _uniform
    fields: Mapping[str, Callable[[float], Floats]] = {}


class Effect(ABC):
    """Gravity, springs, dampers ... Subclasses are frozen dataclasses.

    Their fields are the TOML keys; a ValueError that `bind` raises is reported at the effect's table. Implicit
    integrators find without help how forces change with the positions and velocities of the nodes they act on.

    needs         names of fields of the scene (`[fields]`), such as "temperature", that are in the view
    memory        names of numbers remembered for each node, see `bind`; part of the state
    needs_mass    True if it needs masses in statics, too
    conservative  at any time its forces follow from positions alone, and do no work around a closed path
    dissipates    its forces never do positive work
    internal      its forces have neither a resultant nor a moment: they act between the bodies, or within them
    points        names of fields that are points (x, y) [mm] of the scene: they move and turn with it
    vectors       names of fields that are vectors (x, y): they turn with the scene
    """

    needs: ClassVar[tuple[str, ...]] = ()
    memory: ClassVar[tuple[str, ...]] = ()
    needs_mass: ClassVar[bool] = False
    conservative: ClassVar[bool] = False
    dissipates: ClassVar[bool] = False
    internal: ClassVar[bool] = False
    points: ClassVar[tuple[str, ...]] = ()
    vectors: ClassVar[tuple[str, ...]] = ()

    def times(self) -> tuple[float, ...]:
        """Return times [s] at which its time-dependent action begins, turns or ends; infinite if it never ends."""
        return ()

    def start(self) -> Mapping[str, float]:
        """Return memory at the start of a run, by name; 0 for names that are missing."""
        return {}

    @abstractmethod
    def bind(self, view: EffectView) -> Callable[..., Any]:
        """Return a function (time, force (N, 2)) that adds the effect's nodal forces [N].

        With memory it is (time, force, dt, memory): forces `dt` [s] after the time of the memory, read-only arrays (N,)
        by name. It returns the memory after dt, by name, arrays (N,) or numbers; the core calls it once more after an
        accepted step, and keeps that. dt is 0 for the forces at the start of a step.
        """
