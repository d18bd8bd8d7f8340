"""Checks of effects."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from contactlab.api import Effect, EffectView, Floats, Ints, Profile
from contactlab.model.loading.load_profile import of_nodes
from contactlab.parts.registry import default_registry
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require, tell, untouched
from contactlab.testing.other_values import varied, without_effect
from contactlab.testing.units import FORCE, LONG, TIME, in_other_units, same_in_other_units

TIMES = (0.0, 0.3, 0.7)  # s
LATER = (1e-6, 0.1, 0.7, 30.0)  # s after the last time at which an effect declares a change
SINCE = 0.01  # s after the time of what an effect remembers
ROUND_OFF = 1e-12  # of the largest force
PARTS = 40  # of each leg of a path


@dataclass(frozen=True)
class Scenery:
    """Two bodies of six nodes each, "upper" and "lower", in some state of motion."""

    view: EffectView

    @classmethod
    def moving(cls, seed: int) -> Scenery:
        """A different state for each seed; shapes and masses are the same."""
        x: Floats = np.array([[i, j] for j in range(2) for i in range(3)], np.float64)
        reference: Floats = np.concatenate([x + np.array([0.0, 1.5]), x])
        rng = np.random.default_rng(seed)
        state = (rng.uniform(-0.1, 0.1, reference.shape), rng.uniform(-5.0, 5.0, reference.shape))
        mass: Floats = 1e-6 * np.arange(1.0, 1.0 + len(reference))

        def factors(profile: Profile, nodes: Ints) -> Floats:
            varying = of_nodes(profile, default_registry(), "profile")
            return varying.values(varying.at(reference[nodes]))

        return cls(EffectView(reference, mass, *state, ("upper", "lower"), _nodes, _shares, factors))

    def forces(
        self, effect: Effect, times: tuple[float, ...] = TIMES, since: float = SINCE, more: str = ""
    ) -> list[Floats]:
        """Nodal forces at the times, one after another, from one binding; `more` is a field that grows."""
        add, found = added(effect, self.view, since, more), []
        for time in times:
            force = np.zeros_like(self.view.reference)
            add(time, force)
            found.append(force)
        return found


def added(effect: Effect, view: EffectView, since: float = SINCE, more: str = "") -> Callable[[float, Floats], Any]:
    """Return the function that adds forces; with memory it acts `since` [s] after the memory of the start."""
    add = bound(effect, view, more)
    if not effect.memory:
        return add
    memory = memory_of(effect, view)
    return lambda time, force: add(time, force, since, memory)


def bound(effect: Effect, view: EffectView, more: str = "") -> Callable[..., Any]:
    """Return what `bind` returns, with values at nodes of the fields that the effect needs; `more` grows with time."""
    values, growing = np.linspace(0.5, 1.0, len(view.reference)), {name: float(name == more) for name in effect.needs}
    fields = {name: partial(_grown, values, rate) for name, rate in growing.items()}
    return effect.bind(view._replace(fields=fields))


def _grown(values: Floats, rate: float, time: float) -> Floats:
    return values * (1.0 + rate * time)


def memory_of(effect: Effect, view: EffectView) -> dict[str, Floats]:
    """Memory (N,) at the start of a run, by name."""
    given, nodes = effect.start(), len(view.reference)
    return {name: np.full(nodes, float(given.get(name, 0.0))) for name in effect.memory}


def _nodes(name: str) -> Ints:
    sides = {"bottom": [0, 1, 2], "top": [3, 4, 5], "": range(6)}
    body, _, side = name.partition(".")
    if body not in ("upper", "lower") or side not in sides:
        raise ValueError(f"on: got {name!r}, allowed: upper, lower, and .top or .bottom of them")
    return np.array([i + 6 * (body == "lower") for i in sides[side]], np.int32)


def _shares(names: Sequence[str]) -> tuple[Ints, Floats]:
    nodes: Ints = np.unique(np.concatenate([_nodes(name) for name in names]))
    return nodes, np.full(len(nodes), 1.0 / len(nodes))


def _times(effect: Effect) -> tuple[float, ...]:
    """Times [s] to test: usual ones, the times that it declares, and times between and next to them."""
    own = sorted({0.0, *(time for time in effect.times() if np.isfinite(time))})
    between = [a + share * (b - a) for a, b in pairwise(own) for share in (0.25, 0.5, 0.75)]
    return (*TIMES, *between, *own[1:])


def gives_forces(effect: Effect) -> None:
    """Forces are finite, and some node feels one in some state and at some time."""
    found = [force for seed in range(3) for force in Scenery.moving(seed).forces(effect, _times(effect))]
    require(all(np.isfinite(force).all() for force in found), "a force is not finite")
    require(any(force.any() for force in found), "no node has a force in any state; leave the effect out of the scene")


def adds_to_what_is_there(effect: Effect) -> None:
    """Forces are added to the forces of other effects and loads."""
    scenery = Scenery.moving(1)
    alone = scenery.forces(effect, (0.3,))[0]
    before = np.random.default_rng(2).uniform(-1.0, 1.0, alone.shape) * max(1.0, float(np.abs(alone).max()))
    together = before.copy()
    added(effect, scenery.view)(0.3, together)
    within = ROUND_OFF * float(np.abs(before).max() + np.abs(alone).max())
    agree(together - before, alone, within, "forces added to others")


def follows_the_state(effect: Effect) -> None:
    """The view is always current: a state that changes after `bind` gives the forces of the new state."""
    begun, later = Scenery.moving(3), Scenery.moving(4)
    add = added(effect, begun.view)
    add(0.1, np.zeros_like(begun.view.reference))
    begun.view.displacement[:], begun.view.velocity[:] = later.view.displacement, later.view.velocity
    force = np.zeros_like(begun.view.reference)
    add(0.3, force)
    expected = later.forces(effect, (0.3,))[0]
    agree(force, expected, ROUND_OFF * max(1.0, float(np.abs(expected).max())), "forces after the state has changed")


def remembers_nothing(effect: Effect) -> None:
    """Forces depend on state, memory and time alone: in any order of times, to the last bit, as a restart needs."""
    times = _times(effect)
    forward = Scenery.moving(5).forces(effect, times)
    backward = Scenery.moving(5).forces(effect, times[::-1])[::-1]
    for time, one, other in zip(times, forward, backward, strict=True):
        identical(one, other, f"forces at {time} s, evaluated in another order")


def memory_counts(effect: Effect) -> None:
    """Memory is returned in full, changed by a step; the given memory is left alone, and forces follow it."""
    if not effect.memory:
        raise NotApplicable("it declares no memory")
    view = Scenery.moving(15).view
    add, start = bound(effect, view), memory_of(effect, view)
    force, later = np.zeros_like(view.reference), np.zeros_like(view.reference)
    with untouched(**start):
        found = add(0.3, force, SINCE, start)
    require(isinstance(found, dict), f"its function returned {type(found).__name__}, needed: its memory, a dict")
    for name in effect.memory:
        require(name in found, f"its function does not return {name}, declared in memory {effect.memory}")
        value = np.asarray(found[name], np.float64)
        require(value.shape in ((), start[name].shape), f"{name}: got shape {value.shape}, allowed: a number or (N,)")
        require(bool(np.isfinite(value).all()), f"{name} is not finite")
        require(bool(np.any(value != start[name])), f"a step never changes {name}")
        add(0.3, later, SINCE, {**start, name: start[name] + 0.1})
        require(not np.array_equal(later, force), f"it declares {name}, but no force depends on it")
        later[:] = 0.0


def leaves_the_view_alone(effect: Effect) -> None:
    """Positions, masses and velocities are the model's own arrays."""
    view = Scenery.moving(6).view
    arrays = {"reference": view.reference, "mass": view.mass}
    with untouched(**arrays, displacement=view.displacement, velocity=view.velocity):
        Scenery(view).forces(effect)


def numbers_count(effect: Effect) -> None:
    """A number changes some force, one with a default as well; so does a profile."""
    times = _times(effect)

    def observe(other: Effect) -> list[Floats]:
        return Scenery.moving(7).forces(other, times)

    for name in without_effect(effect, observe):
        raise AssertionError(f"the field {name} never changes a force")
    for field in dataclasses.fields(effect):  # type: ignore[arg-type]
        if field.name == "profile" and effect.profile is None:  # type: ignore[attr-defined]
            wave = dataclasses.replace(effect, profile=Profile(by="x", cosine=(1.0, 0.5, 1.7)))  # type: ignore[type-var]
            same = all(map(np.array_equal, observe(effect), observe(wave)))
            require(not same, "the field profile never changes a force")


def needs_count(effect: Effect) -> None:
    """Forces follow every field of the scene that the effect declares in `needs`, as it is at their time."""
    if not effect.needs:
        raise NotApplicable("it declares no needs")
    scenery, times = Scenery.moving(7), _times(effect)
    for name in effect.needs:
        forces = (scenery.forces(effect, times, more=more) for more in ("", name))
        require(not all(map(np.array_equal, *forces)), f"it declares {name}, but no force depends on it")


def units_do_not_matter_to_it(effect: Effect) -> None:
    """Forces are the same in m, ms and kPa as in mm, s and MPa, by the units of the docstring."""
    for one in (effect, *(other for _, other in varied(effect))):
        other, view = in_other_units(one), Scenery.moving(13).view
        scaled = view._replace(
            reference=LONG * view.reference, displacement=LONG * view.displacement,
            velocity=LONG / TIME * view.velocity, mass=FORCE * TIME**2 / LONG * view.mass,
        )  # fmt: skip
        times = _times(one)
        found = Scenery(scaled).forces(other, tuple(TIME * time for time in times), TIME * SINCE)
        same_in_other_units(found, Scenery(view).forces(one, times), FORCE, "forces")


def masses_are_asked_for(effect: Effect) -> None:
    """An effect in statics works without masses, refuses that by a ValueError, or declares `needs_mass`."""
    if effect.needs_mass:
        raise NotApplicable("it declares needs_mass, and has masses in statics")
    view = Scenery.moving(14).view._replace(mass=np.zeros(0))
    try:
        Scenery(view).forces(effect)
    except Exception as error:
        if type(error) is ValueError and "broadcast" not in str(error):
            return  # the effect has refused it
        what = f"without masses, as in statics, it raises {type(error).__name__}: {error}"
        raise AssertionError(f"{what}; declare needs_mass = True, or raise a ValueError in statics") from error


def work_around_a_path_is_declared(effect: Effect) -> None:
    """Forces do no work around closed paths of displacements, if the part declares that it is `conservative`."""
    if effect.memory:
        raise NotApplicable("its forces depend on its memory: their work around a path depends on time")
    scenery = Scenery.moving(8)
    view, rng = scenery.view, np.random.default_rng(9)
    view.velocity[:] = 0.0
    add, corners = added(effect, view), [rng.uniform(-0.1, 0.1, view.reference.shape) for _ in range(3)]
    work, size = 0.0, 0.0
    times = _times(effect)
    busiest = times[int(np.argmax([np.abs(force).max() for force in scenery.forces(effect, times)]))]
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        for part in range(PARTS):
            view.displacement[:] = start + (part + 0.5) / PARTS * (end - start)
            force = np.zeros_like(view.reference)
            add(busiest, force)
            done = float((force * (end - start)).sum()) / PARTS
            work, size = work + done, size + abs(done)
    still = size > 0.0 and abs(work) <= 1e-3 * size  # midpoint sums err by the square of a part
    _declared(
        effect.conservative,
        still,
        "conservative",
        f"the work around a closed path is {work:.2e} mJ, of {size:.2e} mJ in all",
    )


def power_is_declared(effect: Effect) -> None:
    """Forces never do positive work, if the part declares that it `dissipates`."""
    powers = []
    for seed in range(10, 16):
        scenery = Scenery.moving(seed)
        powers += [float((force * scenery.view.velocity).sum()) for force in scenery.forces(effect)]
    most = max(abs(power) for power in powers)
    takes = most > 0.0 and max(powers) <= ROUND_OFF * most
    _declared(
        effect.dissipates, takes, "dissipates", f"its forces drive a motion with a power of {max(powers):.2e} mJ/s"
    )


def resultants_are_declared(effect: Effect) -> None:
    """Forces have neither a resultant nor a moment, if the part declares that it is `internal`."""
    worst = 0.0
    for seed in range(10, 13):
        scenery = Scenery.moving(seed)
        x = scenery.view.reference + scenery.view.displacement
        for force in scenery.forces(effect):
            size = max(float(np.abs(force).sum()), 1e-300)
            moment = float((x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0]).sum())
            worst = max(worst, float(np.abs(force.sum(axis=0)).max()) / size, abs(moment) / size)
    within = worst <= 1e3 * ROUND_OFF
    _declared(effect.internal, within, "internal", f"a resultant or moment is {worst:.1e} of the forces")


def times_are_declared(effect: Effect) -> None:
    """Forces in a given state stay the same after the last of its `times`: a run that ends later misses nothing."""
    for one in (effect, *(other for _, other in varied(effect))):
        last = max((0.0, *one.times()))
        if not np.isfinite(last):
            continue
        after = Scenery.moving(11).forces(one, tuple(last + later for later in LATER))
        for later, force in zip(LATER[1:], after[1:], strict=True):
            agree(
                force, after[0], ROUND_OFF * max(1.0, float(np.abs(after[0]).max())),
                f"forces {later} s after {last:g} s, the last of its times()",
            )  # fmt: skip


def points_and_vectors_are_fields(effect: Effect) -> None:
    """Names in `points` and `vectors` are fields with two numbers."""
    for name in (*effect.points, *effect.vectors):
        value = getattr(effect, name, None)
        two = isinstance(value, tuple) and len(value) == 2 and all(isinstance(x, float | int) for x in value)
        require(two, f"points and vectors: got {name} ({value!r}), allowed: names of fields with two numbers")


def _declared(says: bool, fact: bool, tag: str, found: str) -> None:
    """A broken promise fails; an undeclared property is reported."""
    require(fact or not says, f"{tag} is True: {found}")
    if fact and not says:
        tell(f"declare {tag} = True")


CHECKS: tuple[Check, ...] = (
    gives_forces,
    work_around_a_path_is_declared,
    power_is_declared,
    resultants_are_declared,
    numbers_count,
    needs_count,
    units_do_not_matter_to_it,
    masses_are_asked_for,
    adds_to_what_is_there,
    follows_the_state,
    remembers_nothing,
    memory_counts,
    leaves_the_view_alone,
    times_are_declared,
    points_and_vectors_are_fields,
)
"""All checks of effects."""
