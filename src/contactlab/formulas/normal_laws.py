"""Normal laws from formulas: pressure and slope of all constraints."""

from __future__ import annotations

from collections import namedtuple
from functools import cache
from typing import Any

import numpy as np

from contactlab.api import Floats, NormalLaw
from contactlab.api.compiled.formulas import made
from contactlab.api.formulas import formulas_of
from contactlab.api.tensors import Vector
from contactlab.formulas import normal_law_kernels as loops
from contactlab.formulas.parameters import parameters_of, values_of

_BEHIND = ("stiffness", "size", "p")


def pressure(law: NormalLaw, *arrays: Floats, **named: Any) -> None:
    """Implement `NormalLaw.pressure`."""
    _kernel(type(law), "pressure", ("gap",))(*arrays, *_rows(law, arrays[0], named), values_of(law))


def adjoint(law: NormalLaw, *arrays: Floats) -> None:
    """Implement `NormalLaw.adjoint`."""
    _kernel(type(law), "adjoint", ("pressure",))(*arrays, values_of(law))


def evolve(
    law: NormalLaw, gap: Floats, pressure: Floats, stiffness: Floats, size: Floats, **named: Any
) -> dict[str, Floats]:
    """Implement `NormalLaw.evolve`."""
    out = np.zeros((len(law.memory), len(gap)))
    kernel = _kernel(type(law), "evolve", ("gap", "pressure"))
    kernel(gap, pressure, stiffness, size, out, *_rows(law, gap, named), values_of(law))
    return dict(zip(law.memory, out, strict=True))


def _rows(law: NormalLaw, gap: Floats, named: dict[str, Any]) -> tuple[Floats, ...]:
    """Return an array (r, k) of all that a law needs and remembers; none for a law of the gap alone."""
    if not named:
        return ()
    values = [row for name in law.named() for row in (named[name].T if name == "position" else (named[name],))]
    return (np.stack([np.broadcast_to(value, gap.shape) for value in values]),)


@cache
def _kernel(kind: type[NormalLaw], name: str, first: tuple[str, ...]) -> Any:
    """Return the loop of a formula differentiated by the numbers `first`, and by a traction if the law needs it."""
    found = formulas_of(kind)
    formula, given = found[name], (*first, *_BEHIND)
    named = kind.named()
    if "traction" in named:
        given, loop, rows = (first[0], "traction", *_BEHIND), loops.with_traction, {}
    elif named:
        given = (*given, "named")
        rows = {one: f"named.{one}" for one in named} | {"position": "Vector(named.x, named.y)"}
        loop = loops.evolve if name == "evolve" else loops.pressure_of_named
    else:
        loop, rows = loops.pressure, {}
    call = f"formula({', '.join(rows.get(argument, argument) for argument in formula.arguments)})"
    if name == "evolve":
        call = f"({call},)" if len(kind.memory) == 1 else call
    else:
        call = f"0.0 * {first[0]} + {call}"
    names: dict[str, Any] = {"formula": formula.function, "__name__": formula.function.__module__, "Vector": Vector}
    names |= {name: found[name] for name in formula.arguments if name in found}
    exec(f"def law({', '.join(given)}):\n    return {call}", names)
    put = {loops.FORMULA: names["law"], loops.PARAMETERS: parameters_of(kind)}
    if named and "traction" not in named:
        parts = {"position": ("x", "y")}
        put[loops.NAMED] = namedtuple("Named", tuple(row for name in kind.named() for row in parts.get(name, (name,))))
    return made(loop, f"{kind.__module__}.{kind.__qualname__}.{name}", put)
