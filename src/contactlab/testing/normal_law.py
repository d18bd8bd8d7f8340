"""Checks of normal laws: pressure, slope and the gap where pressure begins."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from contactlab.api import Enforcement, Floats, NormalLaw
from contactlab.parts.description import units_of
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require, untouched
from contactlab.testing.friction import times_followed
from contactlab.testing.other_values import changed, others, set_from_zero, without_effect
from contactlab.testing.scales import scale_of
from contactlab.testing.units import LONG, STRESS, in_other_units, same_in_other_units, scale_of_unit

COUNT = 201
DEPTHS = 3.0  # lengths of the law that are looked at on both sides of where it begins
BELOW = 0.01  # of that length, below the gap where it begins: there is pressure
APART = 1e-5  # of that length: central differences err by its square, and by round-off over it
FAR = 100.0  # times these gaps is as deep as a limit of the pressure may lie
KINKS = 0.05  # share of gaps near which a law may have a kink: differences across it are wrong
OVERLAP = 0.01  # mm, of a law without a length of its own
UNITS: Mapping[str, str] = {"slip_rate": "mm/s", "dt": "s", "time": "s", "position": "mm"}


def _law(enforcement: Enforcement) -> NormalLaw:
    if not isinstance(enforcement, NormalLaw):
        raise NotApplicable("the enforcement is not a normal law")
    return enforcement


def _length(law: NormalLaw) -> float:
    return scale_of(law, "length_scale", max(OVERLAP, abs(law.begins())))


def _gaps(law: NormalLaw) -> Floats:
    return law.begins() + DEPTHS * _length(law) * np.linspace(-1.0, 1.0, COUNT)


def _pressures(law: Any, gap: Floats, stiffness: float = 1e4, size: float = 0.5) -> tuple[Floats, Floats]:
    return _pressed(law, gap, stiffness, size, named_of(law, len(gap)))


def _pressed(law: Any, gap: Floats, stiffness: float, size: float, named: Mapping[str, Any]) -> tuple[Floats, Floats]:
    pressure, slope = np.full_like(gap, np.nan), np.full_like(gap, np.nan)
    needed = (np.zeros_like(gap), np.zeros_like(gap)) if "traction" in law.needs else ()
    law.pressure(gap.copy(), np.full_like(gap, stiffness), np.full_like(gap, size), pressure, slope, *needed, **named)
    return pressure, slope


def named_of(law: NormalLaw, count: int) -> dict[str, Any]:
    """Needs and memory of a law at the start of a run, for `count` equal conditions; empty for a law of gaps."""
    if "traction" in law.needs:
        return {}
    known: dict[str, Any] = {
        "slip_rate": np.full(count, -30.0), "dt": 1e-4, "time": 1e-3, "position": np.full((count, 2), 0.7),
    }  # fmt: skip
    needed = {name: known.get(name, np.full(count, 1.2)) for name in law.needs}
    given = law.start()
    unknown = sorted(set(given) - {*law.memory})
    require(not unknown, f"start returns {', '.join(unknown)}, not declared in memory {law.memory}")
    return needed | {name: np.full(count, float(given.get(name, 0.0))) for name in law.memory}


def _later(law: Any, gap: Floats, stiffness: float, size: float, named: Mapping[str, Any]) -> dict[str, Any]:
    """Needs and memory after a step that ends at these gaps."""
    if not law.memory:
        return dict(named)
    gap = np.minimum(gap, law.begins())
    pressure = _pressed(law, gap, stiffness, size, named)[0]
    beside = {"stiffness": np.full_like(gap, stiffness), "size": np.full_like(gap, size)}
    found = law.evolve(gap=gap, pressure=pressure, **beside, **named)
    unknown = sorted(set(found) - {*law.memory})
    require(not unknown, f"evolve returns {', '.join(unknown)}, not declared in memory {law.memory}")
    after = {name: np.broadcast_to(np.asarray(value, np.float64), gap.shape).copy() for name, value in found.items()}
    for name, value in after.items():
        require(bool(np.isfinite(value).all()), f"evolve: {name} is not finite")
    return {**named, **after}


def _answers(law: Any, gap: Floats, stiffness: float = 1e4, size: float = 0.5) -> list[Floats]:
    """Pressures, memory after two steps at these gaps, and pressures under it on the way back."""
    named = named_of(law, len(gap))
    after = _later(law, gap, stiffness, size, _later(law, gap, stiffness, size, named))
    back = _pressed(law, np.concatenate([gap[1:], gap[:1]]), stiffness, size, after)
    now = _pressed(law, gap, stiffness, size, named)
    return [*now, *(after[name] for name in law.memory), *back]


def _remembers(enforcement: Enforcement) -> NormalLaw:
    law = _law(enforcement)
    if not law.named() or "traction" in law.needs:
        raise NotApplicable("the law depends on a gap or traction alone: it declares no memory and no other needs")
    return law


def needs_and_memory_count(enforcement: Enforcement) -> None:
    """Needs and memory of a law change a pressure, now or after a step, and evolve changes memory."""
    law = _remembers(enforcement)
    gap, start = _deep(law), named_of(law, COUNT)
    # as after a step to the gap in the middle: some gaps are deeper, others have come back
    named = _later(law, np.full(COUNT, gap[COUNT // 2]), 1e4, 0.5, start)

    def now_and_later(given: Mapping[str, Any]) -> list[Floats]:
        after = _later(law, gap, 1e4, 0.5, given)
        return [*_pressed(law, gap, 1e4, 0.5, given), *_pressed(law, gap, 1e4, 0.5, after)]

    before = now_and_later(named)
    for name in law.named():
        changed = now_and_later({**named, name: 1.3 * named[name] + 0.1 * _length(law)})
        same = all(map(np.array_equal, changed, before))
        require(not same, f"it declares {name}, but no pressure depends on it, now or after a step")
        still = name in law.memory and np.array_equal(named[name], start[name])
        require(not still, f"evolve never changes {name}, at a gap of {gap[COUNT // 2]:.3g} mm")


def memory_is_only_in_the_state(enforcement: Enforcement) -> None:
    """Answers depend on the arguments alone, not on earlier calls, and leave the arguments as they are."""
    law = _remembers(enforcement)
    gap, named = _deep(law), named_of(law, COUNT)
    first = _answers(law, gap)
    for share in (2.0, 0.3):
        _answers(law, share * gap)
    again = "two calls give different answers: state outside of `memory` survives rejected steps"
    require(all(map(np.array_equal, _answers(law, gap), first)), again)
    arrays = {name: value for name, value in named.items() if np.ndim(value)}
    with untouched(**arrays):
        _later(law, gap, 1e4, 0.5, named)


def memory_rests_at_rest(enforcement: Enforcement) -> None:
    """A second step at the same gaps leaves the memory of a law without `dt` as it is: it does not count steps."""
    law = _remembers(enforcement)
    if not law.memory or "dt" in law.needs:
        raise NotApplicable("the law declares no memory, or needs dt: its memory may change while the gap rests")
    after = named_of(law, COUNT)
    for gap in (_deep(law), 0.5 * _deep(law)):  # pressed, and on the way back
        once = _later(law, gap, 1e4, 0.5, after)
        after = _later(law, gap, 1e4, 0.5, once)
        for name in law.memory:
            off = float(np.max(np.abs(after[name] - once[name])))
            allowed = 1e-9 * float(np.max(np.abs(once[name])))  # a difference of a gap and what is left of it
            require(
                off <= allowed,
                f"a second step at the same gaps changes {name} by {off:.2g}, allowed {allowed:.2g}: it depends on the "
                "number of steps; what changes in time needs dt",
            )


def memory_of_a_pressure_follows_time(enforcement: Enforcement) -> None:
    """Two halves of a short step change the memory of a law with `dt` as the whole does."""
    law = _remembers(enforcement)
    if not law.memory or "dt" not in law.needs:
        raise NotApplicable("the law declares no memory, or does not need dt")
    gap = _deep(law)
    named = _later(law, gap, 1e4, 0.5, named_of(law, COUNT))  # memory of a step

    def step(dt: float, known: Mapping[str, Any]) -> dict[str, Any]:
        after = _later(law, gap, 1e4, 0.5, {**named, **known, "dt": dt})
        return {name: after[name] for name in law.memory}

    times_followed({name: named[name] for name in law.memory}, step)


def pressure_is_right_under_what_it_remembers(enforcement: Enforcement) -> None:
    """Pressures after steps at deep gaps neither pull nor fall as gaps close, and slopes are their derivatives."""
    law = _remembers(enforcement)
    gap, step = _deep(law), APART * _length(law)
    named = _later(law, np.full(COUNT, gap.min()), 1e4, 0.5, named_of(law, COUNT))
    pressure, slope = _pressed(law, gap, 1e4, 0.5, named)
    require(pressure.min() >= 0.0, f"it pulls with {-pressure.min():.3g} MPa")
    require(np.diff(pressure).max() <= 1e-12 * pressure.max(), "the pressure falls as the gap closes")
    more, less = (_pressed(law, gap + side * step, 1e4, 0.5, named)[0] for side in (1.0, -1.0))
    error = np.abs(slope - (more - less) / (2.0 * step)) / max(float(np.abs(slope).max()), 1e-300)
    wrong = int(np.count_nonzero(error > 1e-6))
    require(wrong <= int(KINKS * COUNT), f"the slope differs from differences at {wrong} of {COUNT} gaps")


def _deep(law: NormalLaw) -> Floats:
    """Gaps (k,) far below where the law begins, so that what it remembers has come to count."""
    return law.begins() - FAR * _length(law) * np.linspace(1.0, 0.0, COUNT)


def pressure_begins_where_it_says(enforcement: Enforcement) -> None:
    """There is no pressure, and no slope, beyond `begins`, and there is some at gaps below it."""
    law = _law(enforcement)
    gap, begins = _gaps(law), law.begins()
    require(np.isfinite(begins), f"begins gave {begins}, allowed: a gap in mm")
    pressure, slope = _pressures(law, gap)
    open_ = gap > begins + 1e-9 * _length(law)
    far = np.abs(pressure[open_]).max(), np.abs(slope[open_]).max()
    require(max(far) == 0.0, f"pressure or slope is {max(far):.3g} at gaps beyond begins, {begins:.4g} mm")
    for below in (gap[0], begins - BELOW * _length(law)):
        found = _pressures(law, np.array([below]))[0][0]
        require(found > 0.0, f"no pressure at a gap of {below:.4g} mm, though it begins at {begins:.4g} mm")


def pressure_never_pulls_nor_falls(enforcement: Enforcement) -> None:
    """Pressures are at least 0, and a smaller gap has no smaller pressure: else gaps would not be unique."""
    law = _law(enforcement)
    pressure, slope = _pressures(law, _gaps(law))
    require(np.all(np.isfinite(pressure)) and np.all(np.isfinite(slope)), "a pressure or a slope is not finite")
    require(pressure.min() >= 0.0, f"it pulls with {-pressure.min():.3g} MPa")
    require(np.diff(pressure).max() <= 1e-12 * pressure.max(), "the pressure falls as the gap closes")
    require(slope.max() <= 0.0, f"a slope is {slope.max():.3g} MPa/mm, allowed: at most 0")


def slope_is_the_derivative(enforcement: Enforcement) -> None:
    """The slope is the central difference of the pressure, but for gaps near a kink."""
    law = _law(enforcement)
    gap, step = _gaps(law), APART * _length(law)
    _, slope = _pressures(law, gap)
    expected = (_pressures(law, gap + step)[0] - _pressures(law, gap - step)[0]) / (2.0 * step)
    error = np.abs(slope - expected) / np.abs(expected).max()
    allowed = int(KINKS * COUNT)
    wrong = int(np.count_nonzero(error > 1e-6))
    require(wrong <= allowed, f"the slope differs from the difference of pressures at {wrong} of {COUNT} gaps")


def conditions_do_not_know_each_other(enforcement: Enforcement) -> None:
    """A gap alone has the pressure that it has among others."""
    law = _law(enforcement)
    gap = _gaps(law)
    pressure, slope = _pressures(law, gap)
    for i in (0, COUNT // 3, COUNT // 2):
        identical(_pressures(law, gap[i : i + 1]), (pressure[i : i + 1], slope[i : i + 1]), f"gap {i} alone")


def its_numbers_matter(enforcement: Enforcement) -> None:
    """Every number changes a pressure: one without a default near where it begins, any other as far as 100 times that.

    Numbers with a default are checked if all have their defaults, as a given number may replace another.
    """
    law = _law(enforcement)
    gap = _gaps(law)
    before = _pressures(law, gap)[0]
    if law.memory:
        for name in without_effect(law, lambda one: _answers(one, _deep(law))):
            raise AssertionError(f"the field {name} never changes a pressure or memory")
        return
    for name, other in others(law):
        require(np.any(_pressures(other, gap)[0] != before), f"the field {name} changes no pressure")
    fields: Any = dataclasses.fields(law)  # type: ignore[arg-type]
    if any(field.default is not dataclasses.MISSING and getattr(law, field.name) != field.default for field in fields):
        return
    begins = law.begins()
    far = np.concatenate([gap, begins + FAR * (gap - begins), np.zeros(COUNT)])
    before = _under_stress(law, far)
    for name, *others_of_it in (*changed(law), *set_from_zero(law)):
        found = any(np.any(_under_stress(other, far) != before) for other in others_of_it)
        require(found, f"the field {name} never changes a pressure")


def _under_stress(law: Any, gap: Floats) -> Floats:
    """Pressures (k,), and adjoints if the law has tractions of both signs."""
    stiffness, size = np.full_like(gap, 1e4), np.full_like(gap, 0.5)
    if "traction" not in law.needs:
        return _pressures(law, gap)[0]
    traction, out = np.resize(_tractions(), len(gap)), np.zeros((6, len(gap)))
    law.pressure(gap.copy(), stiffness, size, out[0], out[1], traction, out[2])
    law.adjoint(out[0].copy(), stiffness, size, out[3], out[4], traction, out[5])
    return out[[0, 3]]


def energy_is_the_integral(enforcement: Enforcement) -> None:
    """Minus the derivative of the energy is the pressure."""
    law = _law(enforcement)
    if law.needs:
        raise NotApplicable("the pressure depends on more than the gap: the energy is not its integral alone")
    length = _length(law)
    gap = law.begins() - length * np.linspace(0.1, DEPTHS, 20)
    stiffness, size = np.full_like(gap, 1e4), np.full_like(gap, 0.5)
    step = 1e-3 * length
    named = named_of(law, len(gap))
    moved = [law.energy(gap + side * step, stiffness, size, **named) for side in (1.0, -1.0)]
    mean = sum(_pressures(law, gap + share * step)[0] for share in (-1.0, 0.0, 0.0, 0.0, 0.0, 1.0)) / 6.0
    # Simpson's rule over two steps; a kink within a panel costs some thousandths
    agree((moved[1] - moved[0]) / (2.0 * step), mean, 1e-2 * float(np.abs(mean).max()), "slope of the energy")


def gaps_are_only_read(enforcement: Enforcement) -> None:
    """Gaps, stiffness and sizes stay as they are."""
    law: Any = _law(enforcement)
    gap, stiffness, size = _gaps(law), np.full(COUNT, 1e4), np.full(COUNT, 0.5)
    traction = _tractions()
    needed, named = (traction, np.zeros(COUNT)) if "traction" in law.needs else (), named_of(law, COUNT)
    with untouched(gap=gap, stiffness=stiffness, size=size, traction=traction):
        law.pressure(gap, stiffness, size, np.zeros(COUNT), np.zeros(COUNT), *needed, **named)


def _tractions() -> Floats:
    """Normal stresses [MPa] of both signs, as large as a stiffness of 1e4 MPa/mm makes of an overlap."""
    return 1e4 * OVERLAP * np.linspace(-2.0, 2.0, COUNT)


def tractions_press_as_they_should(enforcement: Enforcement) -> None:
    """Tension reduces pressure or has no effect, `by_traction` is the derivative, and gaps count as well."""
    law: Any = _law(enforcement)
    if "traction" not in law.needs:
        raise NotApplicable("the law does not depend on tractions")
    traction, step = _tractions(), 1e-6 * 1e4 * OVERLAP
    size, stiffness = np.full(COUNT, 0.5), np.full(COUNT, 1e4)
    for gap in (-OVERLAP, 0.0, OVERLAP):
        found = []
        for moved in (0.0, step, -step):
            pressure, slope, by_traction = (np.full(COUNT, np.nan) for _ in range(3))
            law.pressure(np.full(COUNT, gap), stiffness, size, pressure, slope, traction + moved, by_traction)
            found.append((pressure, slope, by_traction))
        (pressure, slope, by_traction), (more, *_), (less, *_) = found
        require(bool(np.isfinite(by_traction).all()), f"by_traction is not filled, or not finite, at a gap of {gap} mm")
        require(pressure.min() >= 0.0, f"it pulls with {-pressure.min():.3g} MPa under tension, allowed: 0")
        least, most = by_traction.min(), by_traction.max()
        require(most <= 0.0, f"by_traction is {most:.3g}, allowed: at most 0")
        why = "in equilibrium (traction -p) a larger overlap would have less pressure"
        require(least >= -1.0 - 1e-9, f"by_traction is {least:.3g}, allowed: at least -1: {why}")
        error = np.abs(by_traction - (more - less) / (2.0 * step))
        wrong = int(np.count_nonzero(error > 1e-6 * max(1.0, float(np.abs(by_traction).max()))))
        require(wrong <= int(KINKS * COUNT), f"by_traction differs from differences at {wrong} of {COUNT} tractions")
        deaf = int(np.count_nonzero((by_traction < 0.0) & ~(slope < 0.0)))
        require(not deaf, f"at {deaf} tractions the pressure depends on the traction but not on the gap")


def adjoint_is_right_in_every_variant(enforcement: Enforcement) -> None:
    """The adjoint is 0 under the pressure of a gap of 0, and its derivatives match differences.

    Integers among the fields choose variants: each is checked with one more and one less as well.
    """
    given: Any = _law(enforcement)
    if "traction" not in given.needs or type(given).adjoint is NormalLaw.adjoint:
        raise NotApplicable("the law has no adjoint")
    stiffness, size = np.full(COUNT, 1e4), np.full(COUNT, 0.5)
    traction, step = _tractions(), 1e-6 * 1e4 * OVERLAP
    for law in (given, *_variants(given)):
        pressure, slope, by_traction = np.zeros((3, COUNT))
        law.pressure(np.zeros(COUNT), stiffness, size, pressure, slope, traction, by_traction)
        left = np.abs(_adjoint(law, pressure, traction, stiffness, size)[0][traction < 0.0]).max()
        require(
            left <= 1e-9 * OVERLAP,
            f"under the pressure of a gap of 0 the adjoint is {left:.3g} mm, needed: 0 ({law}); the exact solution has "
            "no gap there",
        )
        pressure = np.abs(traction[::-1] + 0.3 * traction.max())
        value = _adjoint(law, pressure, traction, stiffness, size)
        for row, push, name in ((1, (step, 0.0), "by_pressure"), (2, (0.0, step), "by_traction")):
            more, less = (
                _adjoint(law, pressure + side * push[0], traction + side * push[1], stiffness, size)[0]
                for side in (1.0, -1.0)
            )
            error = np.abs(value[row] - (more - less) / (2.0 * step))
            wrong = int(np.count_nonzero(error > 1e-6 / 1e4 + 1e-6 * np.abs(value[row])))
            require(
                wrong <= int(KINKS * COUNT), f"{name} of the adjoint differs from differences at {wrong} of {COUNT}"
            )
        if _tuned(law):
            continue
        agree(
            _adjoint(law, 2.0 * pressure, 2.0 * traction, 2.0 * stiffness, size)[0], value[0],
            1e-9 * float(np.abs(value[0]).max()), "the adjoint of twice the pressure in front of cells twice as stiff",
        )  # fmt: skip


def _tuned(law: NormalLaw) -> bool:
    """Return whether the law has numbers without a default."""
    return any(field.default is dataclasses.MISSING for field in dataclasses.fields(law))  # type: ignore[arg-type]


def _adjoint(law: Any, pressure: Floats, traction: Floats, stiffness: Floats, size: Floats) -> Floats:
    """The adjoint and its derivatives by pressure and traction, (3, k)."""
    out = np.full((3, len(pressure)), np.nan)
    with untouched(pressure=pressure, traction=traction, stiffness=stiffness, size=size):
        law.adjoint(pressure, stiffness, size, out[0], out[1], traction, out[2])
    require(bool(np.isfinite(out).all()), f"the adjoint or a derivative of it is not filled, or not finite ({law})")
    return out


def _variants(law: NormalLaw) -> Iterator[NormalLaw]:
    """Yield the law with each integer field one more and one less, if it accepts that."""
    for field in dataclasses.fields(law):  # type: ignore[arg-type]
        value = getattr(law, field.name)
        if type(value) is not int:
            continue
        for other in (value + 1, value - 1):
            with contextlib.suppress(ValueError):
                yield dataclasses.replace(law, **{field.name: other})  # type: ignore[type-var]


def stiffness_behind_scales(enforcement: Enforcement) -> None:
    """A law without required numbers follows the stiffness of the cells behind: it is not tuned to a scene."""
    law = _law(enforcement)
    if _tuned(law):
        raise NotApplicable("the law has numbers that a scene must give")
    gap = _gaps(law)
    one, two = (_pressures(law, gap, stiffness)[0] for stiffness in (1e4, 2e4))
    if np.array_equal(one, two) and any("MPa" in unit for unit in units_of(type(law)).values()):
        raise NotApplicable("its pressures follow from its own stresses, not from the cells' stiffness")
    agree(two, 2.0 * one, 1e-9 * float(two.max()), "pressures in front of cells twice as stiff")


def units_do_not_matter_to_the_pressure(enforcement: Enforcement) -> None:
    """A law has the same pressures in m, ms and kPa as in mm, s and MPa, by the units of its docstring."""
    law = _law(enforcement)
    other, gap = in_other_units(law), _gaps(law)
    behind = (STRESS / LONG * 1e4, LONG * 0.5), (1e4, 0.5)
    scaled, named = named_of(other, COUNT), named_of(law, COUNT)
    scaled |= {name: named[name] * (scale_of_unit(UNITS.get(name, "1")) or 1.0) for name in law.needs if named}
    for when, share in (("", 1.0), (" after a step", 0.97)):  # where a step ends a law may have a kink
        there, here = (LONG * share * gap, *behind[0]), (share * gap, *behind[1])
        found, wanted = _pressed(other, *there, scaled), _pressed(law, *here, named)
        same_in_other_units(found[0], wanted[0], STRESS, f"pressures{when}")
        same_in_other_units(found[1], wanted[1], STRESS / LONG, f"slopes{when}")
        scaled, named = _later(other, *there, scaled), _later(law, *here, named)


CHECKS: tuple[Check, ...] = (
    pressure_begins_where_it_says,
    pressure_never_pulls_nor_falls,
    slope_is_the_derivative,
    conditions_do_not_know_each_other,
    its_numbers_matter,
    energy_is_the_integral,
    gaps_are_only_read,
    needs_and_memory_count,
    memory_is_only_in_the_state,
    memory_rests_at_rest,
    memory_of_a_pressure_follows_time,
    pressure_is_right_under_what_it_remembers,
    tractions_press_as_they_should,
    adjoint_is_right_in_every_variant,
    stiffness_behind_scales,
    units_do_not_matter_to_the_pressure,
)
