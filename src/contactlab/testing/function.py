"""Checks of functions: a finite factor at every place, independent of other calls."""

from __future__ import annotations

import math
import pickle

import numpy as np

from contactlab.api import Floats, Function
from contactlab.parts.description import units_of
from contactlab.testing.assertions import Check, NotApplicable, identical, require, untouched
from contactlab.testing.other_values import varied, without_effect
from contactlab.testing.units import LONG, in_other_units

PLACES = np.concatenate([np.linspace(-3.0, 3.0, 61), [-360.0, -180.0, -90.0, 1e-12, 90.0, 180.0, 360.0]])
"""Some mm or seconds around 0, all angles, and the ends."""
RANGE, CELLS, CLOSE = (-5.0, 5.0), 500, 1e-6
"""Range of the search for jumps, its intervals at the start, and the share of the range at which it ends."""


def gives_numbers(function: Function) -> None:
    """A function gives a finite number for each place, as an array of the same length: many places, one or none."""
    for places in (PLACES, PLACES[:1], PLACES[:0]):
        found = np.asarray(function.values(places.copy()))
        require(found.shape == places.shape, f"{len(places)} places give an array of shape {found.shape}")
        require(found.dtype == np.float64, f"it gives {found.dtype}, needed: float64")
        bad = places[~np.isfinite(found)]
        require(not len(bad), f"it is not finite at {bad[:3].tolist()}: a mesh may have nodes there")


def is_not_nothing(function: Function) -> None:
    """Somewhere it is not 0; a scene would better leave out what it multiplies."""
    require(bool(function.values(PLACES.copy()).any()), f"it is 0 at all of {len(PLACES)} places from -360 to 360")


def looks_at_one_place_alone(function: Function) -> None:
    """The value at a place is the same whatever the other places are, and in whatever order: meshes differ in them."""
    whole = function.values(PLACES.copy())
    _same(function.values(PLACES[::-1].copy())[::-1], whole, "places in the other order")
    _same(np.concatenate([function.values(PLACES[i : i + 1].copy()) for i in range(len(PLACES))]), whole, "one by one")


def _same(found: Floats, wanted: Floats, what: str) -> None:
    """Vectorised loops and single values may differ in their last bits."""
    off = float(np.abs(found - wanted).max())
    require(off <= 1e-13 * max(1.0, float(np.abs(wanted).max())), f"{what}: values differ by {off:.2e}")


def remembers_nothing(function: Function) -> None:
    """A second call gives the same to the last bit, and so does its pickle, which other processes get."""
    first = function.values(PLACES.copy())
    identical(function.values(PLACES.copy()), first, "a second call")
    copy = pickle.loads(pickle.dumps(function))
    require(copy == function, "it differs from its copy after pickling")
    identical(copy.values(PLACES.copy()), first, "its pickle")


def leaves_its_places_alone(function: Function) -> None:
    """The array that it is given is the caller's own, and what it gives is a new one, with other numbers as well."""
    for one in _family(function):
        places = PLACES.copy()
        with untouched(places=places):
            found = one.values(places)
        require(not np.may_share_memory(found, places), "it returns its argument, or a view of it")


def numbers_count(function: Function) -> None:
    """Another number for a field changes some value, one with a default as well."""
    for name in without_effect(function, lambda other: other.values(PLACES.copy())):
        raise AssertionError(f"the field {name} changes no value")


def stays_after_its_end(function: Function) -> None:
    """The value is constant from `end` on, which is a number, or infinite if the value always changes."""
    for one in _family(function):
        end = one.end()
        require(not np.isnan(end), "end() is not a number")
        if np.isfinite(end):
            values = one.values(end + np.array([1e-9, 0.1, 1.0, 7.0, 300.0]))
            _same(values, np.full(len(values), values[0]), f"{one}, places after its end() at {end:g}")


def breaks_are_declared(function: Function) -> None:
    """Jumps of the value or its slope are at `breaks()`: integrals are split and load increments end there."""
    for one in _family(function):
        breaks = np.array(one.breaks(), np.float64)
        require(bool(np.isfinite(breaks).all()), "an entry of breaks() is not finite")
        marks = np.append(breaks, one.end())
        marks = marks[np.isfinite(marks)]
        beyond = max(1.0, 0.5 * float(np.ptp(marks))) if len(marks) else 0.0
        for low, high in (RANGE, (marks.min() - beyond, marks.max() + beyond) if len(marks) else RANGE):
            place, jump = _jump(one, low, high, breaks)
            require(jump <= 0.0, f"{one}: its slope jumps by {jump:.3g} at {place:.6g}, which is not in breaks()")


def units_do_not_matter(function: Function) -> None:
    """Factors are the same with places, and fields that are places by their docstring, in m instead of mm."""
    if any(unit.startswith("degree") for unit in units_of(type(function)).values()):
        raise NotApplicable("its places are angles, which have one unit")
    other = in_other_units(function, time=LONG)  # s as mm: whether places are lengths or times is the scene's affair
    found, wanted = other.values(LONG * PLACES), function.values(PLACES.copy())
    same = np.allclose(found, wanted, rtol=1e-6, atol=1e-6 * float(np.abs(wanted).max()))
    require(same, "in m instead of mm it gives other factors: units of its fields are inconsistent")


def _family(function: Function) -> list[Function]:
    """The function, and with other values of its fields: what is wrong may be hidden by a 0."""
    return [function, *(other for _, other in varied(function))]


def _jump(function: Function, low: float, high: float, breaks: Floats) -> tuple[float, float]:
    """Place of the largest jump of the slope except at breaks, and its size; 0 for a smooth function.

    At a kink the difference of slopes over three places does not fall with their distance, elsewhere it does:
    places are refined to `CLOSE` of the range; if the difference stays as large at a 64th of that, there is a kink.
    """
    width = (high - low) / CELLS
    centre = low + (np.arange(CELLS, dtype=np.float64) + 0.5) * width
    size = max(1e-300, float(np.abs(function.values(centre)).max(initial=0.0))) / (high - low)
    bend, halvings = np.full(CELLS, np.inf), math.ceil(math.log2(1.0 / (CELLS * CLOSE)))
    for number in range(halvings + 6):
        if number == halvings:
            close = bend
        tried = centre[:, None] + 0.5 * width * np.array([-1.0, 0.0, 1.0])
        width *= 0.5
        # difference of the slopes on both sides of each place
        at = tried.ravel()
        below, here, above = function.values(np.concatenate([at - width, at, at + width])).reshape(3, -1)
        bends = (np.abs(above - 2.0 * here + below) / width).reshape(tried.shape)
        best = np.arange(len(tried)), bends.argmax(axis=1)
        keep = bends[best] > 0.02 * size
        keep &= np.abs(tried[best][:, None] - breaks).min(axis=1, initial=np.inf) > 4.0 * width
        centre, bend = tried[best][keep], bends[best][keep]
        close = close[keep] if number >= halvings else bend
    kinks = np.flatnonzero(bend > 0.25 * close)
    worst = kinks[bend[kinks].argmax()] if len(kinks) else None
    return (0.0, 0.0) if worst is None else (float(centre[worst]), float(bend[worst]))


CHECKS: tuple[Check, ...] = (
    gives_numbers, is_not_nothing, looks_at_one_place_alone, remembers_nothing, leaves_its_places_alone, numbers_count,
    stays_after_its_end, breaks_are_declared, units_do_not_matter,
)  # fmt: skip
"""All checks of functions."""
