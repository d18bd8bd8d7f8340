"""Checks of friction laws."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from contactlab.api import FrictionBound, FrictionLaw
from contactlab.testing.assertions import Check, require
from contactlab.testing.other_values import any_others

FORCES = np.linspace(0.0, 100.0, 21)  # N, normal forces on a node
LENGTH = 0.5  # mm, what the node stands for


def limit(bound: FrictionBound, normal_force: float, measure: float = LENGTH) -> float:
    """Largest tangential force [N] of a node: min(adhesion * measure, cap * y_n) + coefficient * y_n."""
    adhesion = bound.adhesion * measure
    if math.isfinite(bound.cap):
        adhesion = min(adhesion, bound.cap * normal_force)
    return adhesion + bound.coefficient * normal_force


def numbers_in_range(law: FrictionLaw) -> None:
    """Coefficient and adhesion are finite and not negative, the cap is not negative."""
    bound = law.bound()
    require(isinstance(bound, FrictionBound), f"bound: got {type(bound).__name__}, expected FrictionBound")
    for name in ("coefficient", "adhesion"):
        value = getattr(bound, name)
        require(math.isfinite(value) and value >= 0.0, f"{name}: got {value}, allowed: finite and at least 0")
    require(bound.cap >= 0.0, f"cap: got {bound.cap}, allowed: at least 0, inf for a bound that needs no pressure")


def bound_grows_with_pressure(law: FrictionLaw) -> None:
    """More pressure never allows less friction, and no force is allowed to be negative."""
    limits = [limit(law.bound(), float(force)) for force in FORCES]
    require(limits[0] >= 0.0, f"the bound without pressure is {limits[0]}, allowed: at least 0")
    require(all(np.diff(limits) >= 0.0), "the bound falls with the normal force")


def rubs_at_all(law: FrictionLaw) -> None:
    """Under pressure some tangential force is allowed, or the scene should declare no friction."""
    require(limit(law.bound(), 100.0) > 0.0 or _is_zero_by_its_fields(law), "the bound is zero under any pressure")


def _is_zero_by_its_fields(law: FrictionLaw) -> bool:
    """A law whose numbers are zero asks for a limit of zero itself."""
    fields = [getattr(law, field.name) for field in dataclasses.fields(law)]  # type: ignore[arg-type]
    return any(value == 0.0 for value in fields if isinstance(value, int | float))


def same_bound_twice(law: FrictionLaw) -> None:
    """The bound depends on the law's fields alone."""
    require(law.bound() == law.bound(), "two calls give different bounds")
    copy = dataclasses.replace(law)  # type: ignore[type-var]
    require(copy.bound() == law.bound(), "an equal law gives another bound")


def numbers_count(law: FrictionLaw) -> None:
    """A number that a scene gives changes the bound, one with a default as well."""
    for name, other in any_others(law):
        require(other.bound() != law.bound(), f"the field {name} changes nothing: {law.bound()} whatever it is")


CHECKS: tuple[Check, ...] = (numbers_in_range, bound_grows_with_pressure, rubs_at_all, same_bound_twice, numbers_count)
