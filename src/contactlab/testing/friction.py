"""Checks of friction laws."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contactlab.api import Floats, FrictionBound, FrictionLaw
from contactlab.testing.assertions import Check, NotApplicable, agree, require, tell, untouched
from contactlab.testing.other_values import varied, without_effect
from contactlab.testing.units import STRESS, in_other_units, scale_of_unit

FORCES = np.linspace(0.0, 100.0, 21)  # N, normal forces on a node
LENGTH = 0.5  # mm, length of the node
COUNT = 24  # multipliers of one call of a law with needs
UNITS: Mapping[str, str] = {
    "pressure": "MPa", "slip_rate": "mm/s", "dt": "s", "time": "s", "position": "mm", "cell_size": "mm",
    "traction": "MPa",
}  # fmt: skip
STEPS = 10.0 ** np.arange(-12.0, 1.0)  # s, lengths of steps to try memory with
CHANGES = 1e-9  # of a number that is remembered: changes far above its round-off
LINEAR = 0.1  # what two halves of a short step may differ by from the whole, over its change: 1/2 if dt has no effect


def limit(bound: Any, normal_force: float, measure: float = LENGTH) -> Any:
    """Largest tangential force [N] of a node: min(adhesion * measure, cap * y_n) + coefficient * y_n."""
    coefficient, adhesion, cap = bound
    capped = np.where(np.isfinite(cap), np.where(np.isfinite(cap), cap, 0.0) * normal_force, np.inf)
    return np.minimum(np.asarray(adhesion) * measure, capped) + np.asarray(coefficient) * normal_force


def inputs_of(law: FrictionLaw) -> dict[str, Any]:
    """Needs of the law for `COUNT` multipliers: pressures and stresses to 1 GPa, rates from 0 to 100 m/s both ways."""
    place = np.arange(COUNT)
    rate = np.where(place > 0, 10.0 ** np.linspace(-3.0, 5.0, COUNT), 0.0) * np.where(place % 2, -1.0, 1.0)
    pressure = np.concatenate([[0.0], 10.0 ** np.linspace(-2.0, 3.0, COUNT - 1)])[(place * 7) % COUNT]
    traction = np.concatenate([[0.0, 1.0, 100.0], -(10.0 ** np.linspace(-2.0, 3.0, COUNT - 3))])[(place * 5) % COUNT]
    position = np.stack([np.linspace(-3.0, 5.0, COUNT), np.linspace(1.0, -1.0, COUNT) ** 2], axis=1)
    known: dict[str, Any] = {
        "pressure": pressure, "slip_rate": rate, "dt": 1e-6, "time": 1e-3, "position": position,
        "cell_size": np.linspace(0.1, 1.0, COUNT), "traction": traction,
    }  # fmt: skip
    field = np.linspace(0.5, 1.5, COUNT)
    return {name: known.get(name, field) for name in law.needs}


def start_of(law: FrictionLaw, count: int = COUNT) -> dict[str, Floats]:
    """Memory (count,) of the law at the start of a run."""
    given = law.start()
    unknown = sorted(set(given) - {*law.memory})
    require(not unknown, f"start returns {', '.join(unknown)}, not declared in memory {law.memory}")
    return {name: np.full(count, float(given.get(name, 0.0))) for name in law.memory}


def bound_of(law: FrictionLaw, inputs: Mapping[str, Any], memory: Mapping[str, Floats]) -> Floats:
    """Coefficient, adhesion and cap (3, k) of the law; (3, 1) of a law with constants."""
    found: Any = law.bound(**inputs, **memory)
    require(isinstance(found, FrictionBound), f"bound: got {type(found).__name__}, expected FrictionBound")
    count = _count(inputs, memory)
    return np.stack([_full(f"bound: {name}", value, count) for name, value in found._asdict().items()])


def evolved(law: FrictionLaw, inputs: Mapping[str, Any], memory: Mapping[str, Floats]) -> dict[str, Floats]:
    """Memory after a step."""
    if not law.memory:
        return {}
    found = law.evolve(**inputs, **memory)
    unknown = sorted(set(found) - {*law.memory})
    require(not unknown, f"evolve returns {', '.join(unknown)}, not declared in memory {law.memory}")
    count = _count(inputs, memory)
    after = {name: _full(f"evolve: {name}", value, count) for name, value in found.items()}
    for name, value in after.items():
        bad = ~np.isfinite(value)
        require(not bad.any(), f"evolve: {name} is not finite{_where(bad, inputs)}")
    return {**memory, **after}


def _count(*given: Mapping[str, Any]) -> int:
    sizes = [len(value) for one in given for value in one.values() if np.ndim(value)]
    return sizes[0] if sizes else 1


def _full(what: str, value: Any, count: int) -> Floats:
    array = np.asarray(value, np.float64)
    require(array.shape in ((), (count,)), f"{what}: got shape {array.shape}, allowed: a number or ({count},)")
    return np.broadcast_to(array, (count,)).copy()


def _where(bad: Any, inputs: Mapping[str, Any]) -> str:
    """The inputs of the first multiplier that is bad; empty if all are good."""
    if not inputs or not bad.any():
        return ""
    one = int(np.flatnonzero(bad)[0])
    told = {name: (np.asarray(value)[one] if np.ndim(value) else value) for name, value in inputs.items()}
    return " at " + ", ".join(
        f"{name} {np.array2string(np.asarray(value), precision=3)}" for name, value in told.items()
    )


def _usual(law: FrictionLaw) -> tuple[dict[str, Any], dict[str, Floats]]:
    inputs = inputs_of(law)
    return inputs, start_of(law)


def _answers(law: FrictionLaw) -> list[Floats]:
    """All that the law answers: the bound, memory after a step, and the bound after it."""
    inputs, memory = _usual(law)
    after = evolved(law, inputs, memory)
    return [bound_of(law, inputs, memory), *after.values(), bound_of(law, inputs, after)]


def _differ(one: list[Floats], other: list[Floats]) -> bool:
    return any(not np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


def numbers_in_range(law: FrictionLaw) -> None:
    """Coefficient and adhesion are finite and not negative, the cap is not negative."""
    inputs, memory = _usual(law)
    for remembered in (memory, evolved(law, inputs, memory)):
        bound = bound_of(law, inputs, remembered)
        for name, value in zip(FrictionBound._fields[:2], bound, strict=False):
            bad = ~(np.isfinite(value) & (value >= 0.0))
            got = f"{name}: got {value[bad][:1].sum()}, allowed: finite and at least 0"
            require(not bad.any(), f"{got}{_where(bad, inputs)}")
        cap = bound[2]
        least = cap.min() if not np.isnan(cap).any() else np.nan
        require(least >= 0.0, f"cap: got {least}, allowed: at least 0, inf for a bound that needs no pressure")


def bound_grows_with_pressure(law: FrictionLaw) -> None:
    """More pressure never allows less friction, and no force is allowed to be negative."""
    if "pressure" in law.needs:
        raise NotApplicable("the bound depends on the last step's pressure (needs) and may fall with it")
    bound = bound_of(law, *_usual(law))
    limits = np.array([limit(bound, float(force)) for force in FORCES])
    require(limits[0].min() >= 0.0, f"the bound without pressure is {limits[0].min()}, allowed: at least 0")
    require(np.diff(limits, axis=0).min() >= 0.0, "the bound falls with the normal force")


def rubs_at_all(law: FrictionLaw) -> None:
    """Some tangential force is allowed under pressure, or the scene should declare no friction."""
    largest = limit(bound_of(law, *_usual(law)), 100.0).max()
    # a law whose numbers are zero asks for a limit of zero itself
    fields = [getattr(law, field.name) for field in dataclasses.fields(law)]  # type: ignore[arg-type]
    zero = any(value == 0.0 for value in fields if isinstance(value, int | float))
    require(largest > 0.0 or zero, "the bound is zero under any pressure")


def same_bound_twice(law: FrictionLaw) -> None:
    """The bound depends on the law's fields, needs and memory alone: not on earlier calls."""
    first = _answers(law)
    others, memory = inputs_of(law), start_of(law)
    others = {name: 0.5 * value for name, value in others.items()}
    for _ in range(3):
        bound_of(law, others, evolved(law, others, memory))
    again = "two calls give different answers: state outside of `memory` survives rejected steps"
    require(not _differ(_answers(law), first), again if law.varies else "two calls give different bounds")
    copy = dataclasses.replace(law)  # type: ignore[type-var]
    require(not _differ(_answers(copy), first), "an equal law gives another bound")


def numbers_count(law: FrictionLaw) -> None:
    """A number that a scene gives changes the bound, one with a default as well."""
    for name in without_effect(law, _answers):
        raise AssertionError(f"the field {name} changes no result of {law}")


def _varying(law: FrictionLaw) -> None:
    if not law.varies:
        raise NotApplicable("the law declares no needs and no memory")


def needs_count(law: FrictionLaw) -> None:
    """Everything that a law declares in needs and memory changes its answers."""
    _varying(law)
    inputs, memory = _usual(law)
    before = _now_and_later(law, inputs, memory)
    for name in (*law.needs, *law.memory):
        given, known = ({**one, name: 1.3 * one[name] + 0.1} if name in one else one for one in (inputs, memory))
        after = _now_and_later(law, given, known)
        require(_differ(after, before), f"it declares {name}, but no bound depends on it, now or after a step")


def _now_and_later(law: FrictionLaw, inputs: Mapping[str, Any], memory: Mapping[str, Floats]) -> list[Floats]:
    """Bounds now and after a step."""
    return [bound_of(law, inputs, memory), bound_of(law, inputs, evolved(law, inputs, memory))]


def inputs_are_only_read(law: FrictionLaw) -> None:
    """Arguments of a law, memory included, stay as they are: new memory is what `evolve` returns."""
    _varying(law)
    inputs, memory = _usual(law)
    with untouched(**inputs, **memory):
        bound_of(law, inputs, memory)
        evolved(law, inputs, memory)


def multipliers_do_not_know_each_other(law: FrictionLaw) -> None:
    """A multiplier alone has the bound and the memory that it has among others."""
    _varying(law)
    inputs, memory = _usual(law)
    after = evolved(law, inputs, memory)
    among = [bound_of(law, inputs, after), *after.values()]
    for one in (0, COUNT // 2, COUNT - 1):
        own, known = _part(inputs, one), _part(memory, one)
        later = evolved(law, own, known)
        # functions of NumPy may round differently for other lengths
        for found, wanted in zip([bound_of(law, own, later), *later.values()], among, strict=True):
            expected = wanted[..., one : one + 1] if wanted.shape[-1] > 1 else wanted
            finite = np.isfinite(expected)
            within = 1e-12 * float(np.abs(expected[finite]).max(initial=0.0))
            agree(np.where(finite, found, 0.0), np.where(finite, expected, 0.0), within, "a multiplier alone")


def _part(inputs: Mapping[str, Any], one: int) -> dict[str, Any]:
    return {name: value[one : one + 1] if np.ndim(value) else value for name, value in inputs.items()}


def memory_follows_time(law: FrictionLaw) -> None:
    """Two halves of a short step change memory as the whole does: it follows time, not the number of steps."""
    if not law.memory:
        raise NotApplicable("the law declares no memory")
    inputs, memory = _usual(law)
    found = times_followed(memory, lambda dt, known: evolved(law, _of_length(inputs, dt), known))
    for name in memory:
        require(name in found, f"evolve never changes {name}")


def times_followed(
    memory: Mapping[str, Floats], step: Callable[[float, Mapping[str, Any]], dict[str, Any]]
) -> set[str]:
    """Return names of memory that steps change. Raise AssertionError for one that follows the number of steps."""
    worst: dict[str, list[float]] = {}
    for dt in STEPS:
        whole, halves = step(dt, memory), step(0.5 * dt, step(0.5 * dt, memory))
        for name, before in memory.items():
            change = np.abs(whole[name] - before)
            seen = change > CHANGES * np.abs(whole[name])
            if seen.any():
                off = np.abs(halves[name] - whole[name])[seen] / change[seen]
                worst.setdefault(name, []).append(float(off.max()))
    for name, off_by in worst.items():
        least = min(off_by)
        why = f"two half steps change {name} by {least:.0%} more or less than a whole step, however short"
        require(least < LINEAR, f"{why}: its change should be a rate times dt")
    return {*worst}


def _of_length(inputs: Mapping[str, Any], dt: float) -> dict[str, Any]:
    return {**inputs, "dt": dt} if "dt" in inputs else dict(inputs)


def slip_both_ways(law: FrictionLaw) -> None:
    """Slip forwards and backwards at one rate have the same bound; a dependence on direction is reported."""
    if "slip_rate" not in law.needs:
        raise NotApplicable("the law does not need slip_rate")
    inputs, memory = _usual(law)
    back = {**inputs, "slip_rate": -inputs["slip_rate"]}
    if _differ(_now_and_later(law, inputs, memory), _now_and_later(law, back, memory)):
        tell("slip forwards and backwards at the same rate have different bounds: is an abs missing?")


def units_do_not_matter_to_the_law(law: FrictionLaw) -> None:
    """A law has the same coefficient and cap in m, ms and kPa as in mm, s and MPa, and its adhesion in kPa."""
    for one in (law, *(changed for _, changed in varied(law))):
        _fits_together(one)


def _fits_together(law: FrictionLaw) -> None:
    other = in_other_units(law)
    inputs = inputs_of(law)
    if "slip_rate" in inputs:  # a law may give a rate of zero some small value of its own
        inputs["slip_rate"] = np.where(inputs["slip_rate"] == 0.0, 1.0, inputs["slip_rate"])
    scaled = {name: value * (scale_of_unit(UNITS.get(name, "1")) or 1.0) for name, value in inputs.items()}
    memory, known = start_of(law), start_of(other)
    for step in range(3):
        wanted = bound_of(law, inputs, memory) * [[1.0], [STRESS], [1.0]]
        found = bound_of(other, scaled, known)
        for name, a, b in zip(FrictionBound._fields, found, wanted, strict=True):
            same = np.isclose(a, b, rtol=1e-6, atol=0.0)  # constants below a millionth of the least rate do not count
            after = f" after {step} steps" if step else ""
            require(
                same.all(),
                f"{name}{after}: units of its fields and needs are inconsistent, or the law has a "
                f"number with a unit of its own ({a[~same][:1]} in m, ms and kPa, {b[~same][:1]} in mm, s and MPa)",
            )
        memory, known = evolved(law, inputs, memory), evolved(other, scaled, known)


CHECKS: tuple[Check, ...] = (
    numbers_in_range,
    bound_grows_with_pressure,
    rubs_at_all,
    same_bound_twice,
    numbers_count,
    needs_count,
    inputs_are_only_read,
    multipliers_do_not_know_each_other,
    memory_follows_time,
    slip_both_ways,
    units_do_not_matter_to_the_law,
)
