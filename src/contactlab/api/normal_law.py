"""Normal laws: the pressure between two surfaces as a function of their gap."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.enforcement import Enforcement
from contactlab.api.formulas import formulas_of, install

NormalNeed = Literal["traction", "slip_rate", "dt", "time", "position"]
"""Names that a pressure law may need in addition to fields of the scene, see `NormalLaw`."""

_BEHIND = ("stiffness", "size", "p")
_REFUSED = {
    "pressure": "the law itself gives the pressure, and `evolve` is called with it",
    "cell_size": "`size` is always given",
    "gap": "it is always given",
    "stiffness": "it is always given",
    "size": "it is always given",
    "p": "formulas are always given it",
}
_PANELS = 32  # of the integral of a pressure: 4 Gauss points in each resolve an exponential to round-off


class NormalLaw(Enforcement):
    """An enforcement given by a pressure as a function of the gap, for explicit and implicit integrators alike.

    Subclasses are frozen dataclasses; their fields are the TOML keys. The force of a constraint is the pressure times
    the length of slave surface that belongs to it; the core differentiates a formula, shortens explicit steps by the
    slope, and counts the energy stored in the surfaces. Friction is exact under these normal forces: Coulomb's cone
    without springs.

    A formula `pressure` may take `gap` [mm], `stiffness` [MPa/mm] of the cells behind both surfaces (the
    dilatational modulus over the depth of a cell, both sides in series), `size` [mm] of the slave's segments there, and
    `p`, the numbers among the fields; it returns the pressure [MPa]. A law without a formula gives the array method.

    needs   further quantities that pressures depend on, by name; others cost nothing. Formulas name them as arguments,
            array methods get them as keywords:

            slip_rate  (k,) [mm/s] of the last step, in `evolve` of this one, with sign; the contact needs friction
            dt         [s] length of this step
            time       [s] of the gaps: at the start of explicit steps, at the end of others
            position   (k, 2) [mm] of the slave nodes in the undeformed body, in formulas a `Vector`
            any other name: (k,) a field of the scene (`[fields]`) at this time, such as "temperature"

            "traction", alone: the formula may take `traction` [MPa], the normal stress of the cells behind the slave at
            its nodes, positive in tension, and `stiffness` counts these cells alone; the array method has two more
            arguments, `traction` (k,) and `by_traction` (k,), the derivative by it, -1 to 0, to be filled. Such a law
            may give `adjoint`. It is for statics, and its slave belongs to a body whose element is its tables (q1, q2)
    memory  names of numbers remembered for each constraint: further arguments, changed by `evolve`. They are part
            of the state, and belong to points of the slave; a rejected step changes none of them
    """

    exact: ClassVar[bool] = False
    needs: ClassVar[tuple[NormalNeed | str, ...]] = ()
    memory: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        for name in cls.named():
            if name in _REFUSED:
                raise TypeError(
                    f"{cls.__name__}: got {name} in needs or memory, allowed: other names; {_REFUSED[name]}"
                )
        if "traction" in cls.needs and len(cls.named()) > 1:
            raise TypeError(f'{cls.__name__}: got {cls.named()}, allowed: "traction" alone, or all others without it')
        given = (*_BEHIND, *cls.named())
        allowed = {"pressure": ("gap", *given), "adjoint": ("pressure", *given), "evolve": ("gap", "pressure", *given)}
        install(cls, NormalLaw, allowed, "contactlab.formulas.normal_laws")
        if "traction" not in cls.needs and cls.adjoint is not NormalLaw.adjoint:
            raise TypeError(f'{cls.__name__}.adjoint works on tractions, allowed: with needs = ("traction",)')

    @classmethod
    def named(cls) -> tuple[str, ...]:
        """Return names of all that it needs and remembers."""
        return (*cls.needs, *cls.memory)

    @abstractmethod
    def pressure(
        self, gap: Floats, stiffness: Floats, size: Floats, pressure: Floats, slope: Floats, *more: Any, **named: Any
    ) -> None:
        """Fill `pressure` (k,) [MPa], at least 0, and `slope` (k,) [MPa/mm], its derivative by the gap, at most 0.

        gap (k,) [mm], stiffness (k,) [MPa/mm] of the cells behind, size (k,) [mm] of the slave's segments. Each entry
        depends on its own gap alone, and a larger gap has no larger pressure. `named` are needed and remembered
        quantities, by name; `more` are the two arrays of a traction.
        """

    def start(self) -> Mapping[str, float]:
        """Return memory at the start of a run, by name; 0 for names that are missing."""
        return {}

    def evolve(self, *nothing: Any, **named: Any) -> Mapping[str, Any]:
        """Return memory after an accepted step, by name: numbers or arrays (k,). Needed by a law with memory.

        It is called with all that the law needs and remembers, and with `gap`, `pressure`, `stiffness` and `size`, (k,)
        each; gaps above `begins` are given as `begins`. A formula takes what it names of these and `p`, and returns a
        number, or as many as `memory` has names.
        """
        return {}

    def adjoint(
        self,
        pressure: Floats,
        stiffness: Floats,
        size: Floats,
        adjoint: Floats,
        by_pressure: Floats,
        traction: Floats,
        by_traction: Floats,
    ) -> None:
        """Fill `adjoint` (k,) [mm], the displacements that work on the derivatives of tractions, and their derivatives.

        The forces of a constraint include, on all nodes u of the cells behind, length * adjoint * d(traction)/du: the
        terms that make Nitsche's method adjoint consistent or skew-symmetric. They vanish in the exact solution, with
        pressure equal to minus the traction. A formula takes `pressure` and `traction` [MPa], `stiffness`, `size` and
        `p`. The default leaves zeros, and such a law has none of these forces.
        """

    def begins(self) -> float:
        """Return the gap [mm] beyond which there is no pressure; 0, the default, for a law of overlaps alone."""
        return 0.0

    def energy(self, gap: Floats, stiffness: Floats, size: Floats, *nothing: Any, **named: Any) -> Floats:
        """Return the stored energy per length (k,) [mJ/mm2 of surface] of a gap (k,).

        The default is the integral of the pressure over gaps under the present memory, without the energy dissipated
        by a law. A law that needs "dt" stores nothing by default.
        """
        if "dt" in self.needs:
            return np.zeros_like(gap)
        first = self.begins()
        depth = np.maximum(first - gap, 0.0)
        nodes, weights = np.polynomial.legendre.leggauss(4)
        # panels are shorter towards the gap, as curves are steep there
        edges = 1.0 - np.linspace(1.0, 0.0, _PANELS + 1) ** 2
        length = np.diff(edges)[:, None]
        share = (edges[:-1, None] + 0.5 * (nodes + 1.0) * length).ravel()
        weight = (0.5 * weights * length).ravel()
        at = (first - np.outer(share, depth)).ravel()
        pressure, slope = np.zeros_like(at), np.zeros_like(at)
        count, known = len(share), {name: _repeated(value, len(share)) for name, value in named.items()}
        self.pressure(at, _repeated(stiffness, count), _repeated(size, count), pressure, slope, **known)
        total: Floats = depth * (weight @ pressure.reshape(len(share), -1))
        return total

    @classmethod
    def has_formula(cls) -> bool:
        """Return whether `pressure` was written as a formula."""
        return "pressure" in formulas_of(cls)


def _repeated(value: Any, count: int) -> Any:
    """Return an array (k, ...) so many times, one after the other, as (count k, ...); a number as it is."""
    return np.concatenate([value] * count) if np.ndim(value) else value
