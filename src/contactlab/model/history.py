"""Dependence of the end of a scene on its loading path: decided once, from the scene's declarations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from contactlab.api import Effect, Enforcement, Integrator, NormalLaw
from contactlab.model.bodies.body import Body
from contactlab.model.loading.declared import courses_in
from contactlab.scene.scene import Scene


@dataclass(frozen=True)
class History:
    """Keys of a scene by which its end depends on the loading path.

    laws      bodies whose material has memory (plastic flow, rate-form stress) or depends on rate, pressure laws and
              effects with memory
    friction  contacts with friction
    motion    inertia in time: a duration in seconds with an integrator with inertia
    asked     keys that request the path although the end may not depend on it: `time.history`, and, of runs with
              inertia that end when they have settled, times that the scene gives itself
    """

    laws: tuple[str, ...] = ()
    friction: tuple[str, ...] = ()
    motion: tuple[str, ...] = ()
    asked: tuple[str, ...] = ()

    @property
    def because(self) -> tuple[str, ...]:
        """All keys, the most important first."""
        return self.motion + self.laws + self.friction + self.asked

    def __bool__(self) -> bool:
        """Return whether the path must be followed."""
        return bool(self.because)

    def __str__(self) -> str:
        return ", ".join(self.because) or "none: the end does not depend on the loading path"


def history_of(
    scene: Scene,
    bodies: Iterable[Body],
    enforcements: Mapping[str, Enforcement],
    effects: Iterable[Effect],
    integrator: Integrator,
) -> History:
    """Return the keys of a scene that make it path-dependent; `enforcements` by the keys of their contacts."""
    laws = [f"bodies.{b.name}.material" for b in bodies if b.material.history_size or b.material.rate_dependent]
    laws += [f"{key}.enforcement" for key, one in enforcements.items() if isinstance(one, NormalLaw) and one.memory]
    laws += [f"effects.{i}" for i, effect in enumerate(effects) if effect.memory]
    return History(
        laws=tuple(laws),
        friction=tuple(f"contacts.{i}.friction" for i, contact in enumerate(scene.contacts) if contact.friction),
        motion=("time.end",) if integrator.inertia and scene.time.end != "auto" else (),
        asked=(("time.history",) if scene.time.history else ()) + _own_times(scene, integrator),
    )


def _own_times(scene: Scene, integrator: Integrator) -> tuple[str, ...]:
    """Return keys in seconds that give a time or speed to a run that otherwise finds its own times."""
    if not integrator.inertia or scene.time.end != "auto":
        return ()
    given = [f"time.{name}" for name in ("ramp", "damping", "relaxation") if getattr(scene.time, name) is not None]
    given += [key for key, _, course in courses_in(scene) if course.timed]
    given += [f"contacts.{i}.start.duration" for i, spec in enumerate(scene.contacts) if spec.start.duration]
    # effects may depend on time, or need it (except springs): their path is their own
    given += [f"effects.{i}" for i in range(len(scene.effects))]
    return tuple(given)
