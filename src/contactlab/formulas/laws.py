"""Material models (laws) from formulas: stress, tangent, energy and wave speeds.

A law's formulas name their inputs:

    F       deformation gradient, a `Tensor` with zz = 1: the law is "finite"
    H       displacement gradient du/dX, a `Tensor` with zz = 0: the law is "small"
    G       gradient of the displacement increment at the middle of the step: the law is of "rate" form
    history memory of the law, named by `history_names`: at the last accepted step when `stress` is called
    dt      length of the step [s]
    p       the numbers among the fields of the law, and names in its `needs`

`stress` gives the Cauchy stress, a `Tensor`; a law with history gives (stress, new), `new` in the order of
`history_names`. `energy` and `dissipation` give a number per current volume (per undeformed volume of "small" laws).
"""

from __future__ import annotations

import weakref
from collections import namedtuple
from functools import cache, cached_property
from typing import Any

import numpy as np

from contactlab.api import Floats, Material
from contactlab.api.compiled.formulas import Slot, copied, made, plain
from contactlab.api.differences import speeds_of_moduli
from contactlab.api.formulas import formulas_of
from contactlab.api.mathematics import seeds
from contactlab.api.tensors import Tensor, Vector
from contactlab.formulas import law_kernels as points
from contactlab.formulas.parameters import parameters_of, values_of


class _Kernels:
    """The kernels of one class of laws, each made at its first call."""

    def __init__(self, kind: type[Material]) -> None:
        self.kind, self.formulas = kind, formulas_of(kind)
        self.memory: Any = namedtuple("Memory", kind.history_names) if kind.history_size else None
        stress = self.formulas.get("stress")  # None: by hand
        remembers = self.memory is not None or (stress is not None and "dt" in stress.arguments)
        self.template = points.step if remembers else points.stress
        self.parameters = parameters_of(kind)

    @cached_property
    def stress(self) -> Any:
        return self._made(self.template, "stress")

    @cached_property
    def plain_stress(self) -> Any:
        return plain(self.called("stress"))

    @cached_property
    def tangent(self) -> Any:
        return self._made(points.tangent, "stress")

    @cached_property
    def energy(self) -> Any:
        return self._made(points.density, "energy")

    @cached_property
    def dissipation(self) -> Any:
        return self._made(points.density, "dissipation")

    def called(self, name: str) -> Any:
        """Return the formula, called with all inputs of a law's formula; a stress without history gets an empty one."""
        found = self.formulas[name]
        rows = {"position": "Vector(history.x, history.y)"}
        needs = {need: rows.get(need, f"history.{need}") for need in self.kind.needs}
        given = ", ".join((_GIVEN | needs).get(name, name) for name in found.arguments)
        source = f"def law(measure, history, dt, p):\n    return formula({given})"
        names: dict[str, Any] = {"formula": found.function, "__name__": found.function.__module__, "Vector": Vector}
        names |= {name: self.formulas[name] for name in found.arguments if name not in _GIVEN | needs}
        exec(source + (", ()" if name == "stress" and not self.kind.own_history() else ""), names)
        return names["law"]

    def given(self, name: str) -> dict[Slot, Any]:
        """Return values of the template slots for a formula."""
        return {
            points.FORMULA: self.called(name),
            points.MEASURE: points.finite if self.kind.kinematics == "finite" else points.small,
            points.MEMORY: points.nothing if self.memory is None else points.remembered,
            points.STORED: self.memory,
            points.PARAMETERS: self.parameters,
        }

    def _made(self, template: Any, name: str) -> Any:
        return made(template, f"{self.kind.__module__}.{self.kind.__qualname__}", self.given(name))


_GIVEN = {"F": "measure", "H": "measure", "G": "measure", "history": "history", "dt": "dt", "p": "p"}
_of_class = cache(_Kernels)


class _Bound:
    """The kernels of the class of a law, and the law's numbers (p, 1)."""

    def __init__(self, law: Material) -> None:
        self.kernels = _of_class(type(law))
        self.values = values_of(law)
        self.remembers = self.kernels.template is points.step

    @cached_property
    def stress(self) -> Any:
        """The kernel of the stress."""
        return self.kernels.stress


_bound: dict[int, _Bound] = {}


def _of(law: Material) -> _Bound:
    """Return the bound kernels of a law, kept as long as it lives."""
    found = _bound.get(id(law))
    if found is None:
        found = _bound[id(law)] = _Bound(law)
        weakref.finalize(law, _bound.pop, id(law), None)
    return found


def stress(law: Material, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
    """Implement `Material.stress`."""
    bound = _of(law)
    if not bound.remembers:
        bound.stress(gradient, stress, bound.values)
        return
    if new_history is not history:
        new_history[:] = history
    bound.stress(gradient, stress, bound.values, new_history, dt)


def stress_in_python(
    law: Material, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats
) -> None:
    """Compute `stress` by formulas that are not compiled."""
    bound = _of(law)
    new_history[:] = history
    copied(points.step, bound.kernels.given("stress"))(gradient, stress, bound.values, new_history, dt)


def tangent(law: Material, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
    """Implement `Material.tangent`."""
    bound = _of(law)
    bound.kernels.tangent(gradient, history, dt, tangent, bound.values)


def energy(law: Material, gradient: Floats, history: Floats, energy: Floats) -> None:
    """Implement `Material.energy`."""
    bound = _of(law)
    bound.kernels.energy(gradient, history, energy, bound.values)


def dissipation(law: Material, gradient: Floats, history: Floats, dissipation: Floats) -> None:
    """Implement `Material.dissipation`."""
    bound = _of(law)
    bound.kernels.dissipation(gradient, history, dissipation, bound.values)


def wave_speeds(law: Material) -> tuple[float, float]:
    """Implement `Material.wave_speeds`, by the derivative of the stress at rest; compiles only points.nothing."""
    kernels, values = _of(law).kernels, _of(law).values
    finite = law.kinematics == "finite"
    a, b, c, d = seeds([1.0, 0.0, 0.0, 1.0] if finite else [0.0] * 4)
    rest = Tensor(a, b, c, d, 1.0 if finite else 0.0)
    history = kernels.memory(*np.zeros(law.history_size).tolist()) if kernels.memory is not None else ()
    found, _ = kernels.plain_stress(rest, history, 0.0, kernels.parameters(*values[:, 0].tolist()))
    rows = (found.xx, found.yy, found.zz, found.xy)
    return speeds_of_moduli(law, np.stack([np.broadcast_to(getattr(row, "derivatives", 0.0), 4) for row in rows]))
