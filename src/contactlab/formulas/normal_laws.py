"""Normal laws from formulas: pressure and slope of all conditions."""

from __future__ import annotations

from functools import cache
from typing import Any

from contactlab.api import Floats, NormalLaw
from contactlab.api.compiled.formulas import made
from contactlab.api.formulas import formulas_of
from contactlab.formulas import normal_law_kernels as loops
from contactlab.formulas.parameters import parameters_of, values_of


def pressure(law: NormalLaw, *arrays: Floats) -> None:
    """`NormalLaw.pressure`."""
    _kernel(type(law), "pressure", "gap")(*arrays, values_of(law))


def adjoint(law: NormalLaw, *arrays: Floats) -> None:
    """`NormalLaw.adjoint`."""
    _kernel(type(law), "adjoint", "pressure")(*arrays, values_of(law))


@cache
def _kernel(kind: type[NormalLaw], name: str, first: str) -> Any:
    """The loop for a formula that is differentiated by the number `first` and by what the law needs."""
    found = formulas_of(kind)
    formula = found[name]
    given = ", ".join((first, *kind.needs, "stiffness", "size", "p"))
    source = f"def law({given}):\n    return 0.0 * {first} + formula({', '.join(formula.arguments)})"
    names: dict[str, Any] = {"formula": formula.function, "__name__": formula.function.__module__}
    names |= {name: found[name] for name in formula.arguments if name in found}
    exec(source, names)
    put = {loops.FORMULA: names["law"], loops.PARAMETERS: parameters_of(kind)}
    loop = loops.with_traction if kind.needs else loops.pressure
    return made(loop, f"{kind.__module__}.{kind.__qualname__}.{name}", put)
