"""Checks of functions: a finite factor at every place, and the same one whatever else is asked."""

from __future__ import annotations

import pickle

import numpy as np

from contactlab.api import Floats, Function
from contactlab.testing.assertions import Check, identical, require, untouched
from contactlab.testing.other_values import others, switched_on

PLACES = np.concatenate([np.linspace(-3.0, 3.0, 61), [-360.0, -180.0, -90.0, 1e-12, 90.0, 180.0, 360.0]])
"""Some mm or seconds around 0, all angles, and the rims."""


def gives_numbers(function: Function) -> None:
    """One finite number for each place, as an array of the same length: for many places, for one and for none."""
    for places in (PLACES, PLACES[:1], PLACES[:0]):
        found = np.asarray(function.values(places.copy()))
        require(found.shape == places.shape, f"{len(places)} places give an array of shape {found.shape}")
        require(found.dtype == np.float64, f"it gives {found.dtype}, float64 is needed")
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
    require(copy == function, "it is not equal to what its pickle brings back")
    identical(copy.values(PLACES.copy()), first, "its pickle")


def leaves_its_places_alone(function: Function) -> None:
    """The array that it is given is the caller's own, and what it gives is a new one."""
    places = PLACES.copy()
    with untouched(places=places):
        found = function.values(places)
    require(not np.may_share_memory(found, places), "it gives back the array that it was given, or a view of it")


def numbers_count(function: Function) -> None:
    """Another number for a field changes some value."""
    values = function.values(PLACES.copy())
    for name, other in (*others(function), *switched_on(function)):
        require(not np.array_equal(values, other.values(PLACES.copy())), f"the field {name} changes no value")


def stays_after_its_end(function: Function) -> None:
    """From its `end` on the value is the same; it is a number, or infinite if it always changes."""
    end = function.end()
    require(not np.isnan(end), "end() is not a number")
    if np.isfinite(end):
        values = function.values(end + np.array([1e-9, 0.1, 1.0, 7.0, 300.0]))
        _same(values, np.full(len(values), values[0]), f"places after its end() at {end:g}")
    require(bool(np.isfinite(np.array(function.breaks(), np.float64)).all()), "an entry of breaks() is not finite")


CHECKS: tuple[Check, ...] = (
    gives_numbers, is_not_nothing, looks_at_one_place_alone, remembers_nothing, leaves_its_places_alone, numbers_count,
    stays_after_its_end,
)  # fmt: skip
"""All checks of functions."""
