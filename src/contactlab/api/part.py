"""The entry of a plugin component (part): known before any of its code is imported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, get_args

Kind = Literal[
    "element",
    "material",
    "mesh",
    "contact",
    "friction",
    "enforcement",
    "integrator",
    "effect",
    "function",
    "recorder",
    "watch",
    "case",
    "measure",
    "reference",
]
KINDS: Final[tuple[str, ...]] = get_args(Kind)

CONTRACT_VERSION: Final = 2
"""Version of `contactlab.api`. A part made for another version is refused when it is loaded."""

NEW_IN_2: Final[Mapping[str, str]] = {
    "integrator": "derive from ExplicitIntegrator or ImplicitIntegrator and drop the attributes needs, explicit "
    "and, of explicit ones, inertia; give work and reaction in every accepted Step; leave the clock, and the fields "
    "reaction and last_dt of your memory, to the core; call begin of the equations begin_step",
    "contact": "take one ContactView instead of slave, master, at, near, reach and memory in pieces, normals and "
    "conditions; call slopes derivatives, and PieceSlopes PieceDerivatives",
    "enforcement": "call ChainedRows FactoredRows, chained factored, and solve_chained solve_factored",
}
"""Changes that parts of version 1 need, by kind."""

INSTEAD: Final[Mapping[str, str]] = {
    name: f'forces = "{forces}"' for name, forces in
    (("conjugate", "consistent"), ("conjugate_where", "consistent"), ("conjugate_in", "auto"))
}  # fmt: skip
"""Names of enforcements that earlier forms of version 2 had, and what is declared in their place."""

MOVED_IN_2: Final[Mapping[str, str]] = {
    **{f"contactlab.api.{name}": f"contactlab.api.compiled.{name}"
       for name in ("bound_arrays", "kernel", "late", "unpack")},
    **{f"contactlab.api.{name}": f"contactlab.api.drawing.{name}" for name in ("colours", "units")},
    "contactlab.api.slopes": "contactlab.api.derivatives",
    "ChainedRows": "FactoredRows", "ContactSlopes": "ContactDerivatives", "PieceSlopes": "PieceDerivatives",
}  # fmt: skip
"""Modules and names of version 1 that are called otherwise in version 2."""


def what_to_change(kind: str, version: int) -> str:
    """Return advice on how to bring a part of a kind from `version` of the contract to this version."""
    if version != 1:
        return f"install a release of contactlab with version {version} of the contract, or a newer one of the part"
    return NEW_IN_2.get(kind, "nothing but api=2, if its tests pass")


@dataclass(frozen=True)
class Part:
    """A plugin component on offer: enough to list it, and its import path.

    kind       one of `KINDS`
    name       kebab-case, as written in a scene: "mortar-p0"
    target     "package.module:ClassName", imported only when a scene uses the part
    summary    one line for `contactlab parts`
    reference  publication of the method
    api        version of the contract that the part was written for
    """

    kind: Kind
    name: str
    target: str
    summary: str
    reference: str = ""
    api: int = CONTRACT_VERSION
