"""Measures of a contact's last pressure that every comparison reports."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contactlab.api import ContactCurve, Floats, Ints, Record, RunMeasure, Solution


@dataclass(frozen=True)
class ContactLength(RunMeasure):
    """Length of the deformed surface whose nodes are pressed, from half a segment outside to half a segment outside."""

    title: ClassVar[str] = "length of contact"
    unit: ClassVar[str] = "length"
    meaning: ClassVar[str] = "Length of the deformed slave surface that is pressed, to half a segment beyond its nodes."
    digits: ClassVar[int] = 4

    def evaluate(self, record: Record, contact: str, reference: Solution | None) -> float:
        """Sum half of the two segments next to each pressed node, of its own chain; NaN if no pressure is known."""
        curve = record.curve(contact)
        if np.isnan(curve.nodal_pressure).all():
            return math.nan
        length = np.zeros(len(curve.x))
        for first, second in _segments(curve):
            half = 0.5 * math.hypot(curve.x[second] - curve.x[first], curve.y[second] - curve.y[first])
            length[first] += half
            length[second] += half
        return float(length[_pressed(curve)].sum())


@dataclass(frozen=True)
class PressureCentre(RunMeasure):
    """Point where the resultant of the pressure acts: a shift shows sliding, friction, or a lost symmetry."""

    title: ClassVar[str] = "centre of pressure"
    unit: ClassVar[str] = "length"
    meaning: ClassVar[str] = "Mean deformed x of the pressed nodes, weighted by their pressures."
    digits: ClassVar[int] = 3

    def evaluate(self, record: Record, contact: str, reference: Solution | None) -> float:
        """Return the sum of x p over the sum of p; NaN if nothing is pressed."""
        curve = record.curve(contact)
        pressed = _pressed(curve)
        total = float(curve.nodal_pressure[pressed].sum())
        if total == 0.0:
            return math.nan
        return float((curve.x[pressed] * curve.nodal_pressure[pressed]).sum()) / total


@dataclass(frozen=True)
class PeakError(RunMeasure):
    """Largest pressure against the reference's."""

    title: ClassVar[str] = "error of the largest pressure"
    unit: ClassVar[str] = "share"
    meaning: ClassVar[str] = "Largest nodal pressure over the largest of the reference, less one."
    digits: ClassVar[int] = 2

    def evaluate(self, record: Record, contact: str, reference: Solution | None) -> float:
        """Compare unaveraged multipliers; NaN without a reference or a pressure."""
        if reference is None:
            return math.nan
        exact = float(np.max(reference.pressure, initial=0.0))
        found = _largest(record.curve(contact).pressure)
        return found / exact - 1.0 if exact > 0.0 and found > 0.0 else math.nan


def _largest(values: Floats) -> float:
    return float(np.nan_to_num(values).max(initial=0.0))


def _pressed(curve: ContactCurve) -> Ints:
    return np.asarray(np.flatnonzero(np.nan_to_num(curve.nodal_pressure) > 0.0), np.int32)


def _segments(curve: ContactCurve) -> list[tuple[int, int]]:
    """Neighbours of the same chain."""
    same = np.flatnonzero(curve.chain[:-1] == curve.chain[1:])
    return [(int(k), int(k) + 1) for k in same]
