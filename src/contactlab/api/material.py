"""Materials: plane-strain material models on blocks of points."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from contactlab.api.arrays import Floats
from contactlab.api.formulas import Formula, array_method, formulas_of, install

Kinematics = Literal["small", "finite", "rate"]

MaterialNeed = Literal["position", "time", "cell_size"]
"""Names that a law may need in addition to fields of the scene, see `Material`."""

_FORMULAS = ("stress", "energy", "dissipation")
_KINEMATICS: dict[str, Kinematics] = {"F": "finite", "H": "small", "G": "rate"}
_ARGUMENTS = (*_KINEMATICS, "history", "dt", "p")


def _rows(need: str) -> tuple[str, ...]:
    return ("x", "y") if need == "position" else (need,)


def _same_measure(kind: type[Material], formulas: Mapping[str, Formula]) -> None:
    """Raise TypeError if a formula of a law names a deformation of other kinematics: all of them get the same one."""
    given = [name for name, kinematics in _KINEMATICS.items() if kinematics == getattr(kind, "kinematics", None)]
    for name in _FORMULAS:
        for argument in formulas[name].arguments if name in formulas and given else ():
            if argument in _KINEMATICS and argument not in given:
                raise TypeError(
                    f"{kind.__name__}.{name}: got the argument {argument}, allowed: {given[0]}, as kinematics is "
                    f"{kind.kinematics!r} ({formulas[name].place})"
                )


class Material(ABC):
    """A plane-strain material model (law). Subclasses are frozen dataclasses; their fields are the TOML keys.

    A law is written by formulas, `stress(F, p)` and perhaps `energy(F, p)` of a point (docs/parts/material.md), from
    which the core makes all methods below, or by `stress` of a block of points in NumPy or numba. Each formula may have
    an array method in its place.

    density        [t/mm3], a field of every law
    kinematics     meaning of the `gradient` argument, and geometry on which forces act:
                   "small"   du/dX, forces on the undeformed geometry (displacements small)
                   "finite"  dX/dx, the inverse of the deformation gradient, forces on the current geometry
                   "rate"    the gradient of the displacement increment by positions at the middle of the step,
                             forces on the current geometry
    history_size   numbers kept per point, all zero at the start
    history_names  their names in output, one per number; the equivalent plastic strain must be called
                   "equivalent_plastic_strain"
    needs          names of further numbers that the law follows: "position" [mm] of the point in the undeformed body,
                   "time" [s] of the stress, "cell_size" [mm], the root of a cell's area, or a field of the scene such
                   as "temperature" (`[fields]`). The core keeps them in rows of `history` behind the law's own and
                   adds them to `history_names`, the position as "x" and "y"; formulas name them as arguments
    rate_dependent True for a law whose stress depends on `dt`, the time that a change of strain takes (creep,
                   relaxation, viscosity): static load increments then advance time as well as load
    time_scale     name of the field [s] with the relaxation time of a `rate_dependent` law; checks take steps around it
    stress_free    False for a law with a stress at zero deformation (thermal strain, residual stress)
    implicit_euler  True for a "small" or "finite" law whose history advances by an implicit Euler step, from `history`
                   to the state at `gradient`, and belongs to the undeformed body (it does not turn with it): implicit
                   integrators then integrate flow to second order in the step, by calls of `stress` along the way
    isotropic      False for a law with directions of its own
    without        effects of this law ("finite strain", "plasticity"), each with a law without it
    beyond         effects that this law leaves out, each with a law that has it
    """

    density: float
    kinematics: ClassVar[Kinematics]
    history_size: ClassVar[int] = 0
    history_names: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[tuple[MaterialNeed | str, ...]] = ()
    rate_dependent: ClassVar[bool] = False
    time_scale: ClassVar[str] = ""
    stress_free: ClassVar[bool] = True
    implicit_euler: ClassVar[bool] = False
    isotropic: ClassVar[bool] = True
    without: ClassVar[Mapping[str, str]] = {}
    beyond: ClassVar[Mapping[str, str]] = {}
    has_energy: ClassVar[bool] = False

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        if "needs" in vars(cls):
            rows = [row for need in cls.needs for row in _rows(need)]
            own = [name for name in cls.history_names if name not in rows]
            cls.history_names, cls.history_size = (*own, *rows), len(own) + len(rows)
        arguments = (*_ARGUMENTS, *cls.needs)
        install(cls, Material, dict.fromkeys(_FORMULAS, arguments), "contactlab.formulas.laws")
        formulas = formulas_of(cls)
        cls.has_energy = cls.has_energy or "energy" in formulas
        if "stress" in formulas and "kinematics" not in vars(cls):
            measures = formulas["stress"].arguments
            cls.kinematics = next(kind for name, kind in _KINEMATICS.items() if name in measures)
        _same_measure(cls, formulas)
        if "stress" not in formulas:
            return
        for name in ("tangent", "wave_speeds"):
            if getattr(cls, name) is getattr(Material, name):
                setattr(cls, name, array_method(getattr(Material, name), "contactlab.formulas.laws", name))

    @classmethod
    def own_history(cls) -> int:
        """Return the rows of the history that the law fills; the core fills the rows behind them, which it `needs`."""
        return cls.history_size - sum(len(_rows(need)) for need in cls.needs)

    @abstractmethod
    def stress(self, gradient: Floats, history: Floats, dt: float, stress: Floats, new_history: Floats) -> None:
        """Fill Cauchy `stress` (4, P) [MPa] and `new_history` (h, P).

        `gradient` (4, P) is defined by `kinematics`; `history` belongs to the last accepted step.
        `history` and `new_history` may be the same array: read a point before you write it. Rows that the law `needs`
        are filled in both.
        `dt` [s] is the step that led here (0 before the first step).
        """

    def wave_speeds(self) -> tuple[float, float]:
        """Return dilatational and shear speed [mm/s] of the undeformed material; they set the stable step.

        The default finds them from the tangent at rest.
        """
        from contactlab.api.differences import speeds_at_rest

        return speeds_at_rest(self)

    def stiffening(self, gradient: Floats, stress: Floats, out: Floats) -> None:
        """Fill out (P,) with a bound of the fastest wave's modulus over its value at rest (`wave_speeds`).

        Explicit steps are shortened by its root: if the bound is too low, a run diverges. The modulus is the largest
        eigenvalue of the acoustic tensor on the current geometry, in any direction. The default finds it from `tangent`
        for "finite" laws without history that do not depend on the rate, at the cost of many stresses, and is 1 for all
        others: laws in rate form and laws with history that stiffen must override it.
        """
        if self.kinematics == "finite" and not self.own_history() and not self.rate_dependent:
            from contactlab.api.differences import stiffening_of_waves

            stiffening_of_waves(self, gradient, out)
        else:
            out[:] = 1.0

    def tangent(self, gradient: Floats, history: Floats, dt: float, tangent: Floats) -> None:
        """Fill `tangent` (4, 4, P): d(stress row)/d(gradient row), of the result of `stress`.

        The default takes central differences of `stress`: accurate, at the cost of eight calls of `stress`.
        """
        from contactlab.api.differences import tangent_by_differences

        tangent_by_differences(self, gradient, history, dt, tangent)

    def complete_history(self, history: Floats) -> None:  # noqa: B027
        """Set rows of `history` (h, P) that follow from others, after linear extrapolation of all rows.

        Only called on laws that declare `implicit_euler`.
        """

    def energy(self, gradient: Floats, history: Floats, energy: Floats) -> None:
        """Fill the stored energy per current volume (P,) [mJ/mm3].

        "small" laws: per undeformed volume. Only called on laws whose `has_energy` is true.
        """
        raise NotImplementedError(f"{type(self).__name__} declares no stored energy")

    def elastic_limit(self) -> float:
        """Return the von Mises stress [MPa] beyond which the material, but not the law, would yield; inf without one.

        A run that exceeds it warns at its end.
        """
        return math.inf

    def dissipation(self, gradient: Floats, history: Floats, dissipation: Floats) -> None:
        """Fill the energy dissipated so far, per volume like `energy`, (P,) [mJ/mm3]; the default is 0."""
        dissipation[:] = 0.0
