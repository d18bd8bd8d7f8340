"""What a plugin says about a part before anything of it is imported."""

from __future__ import annotations

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
    "recorder",
    "watch",
    "case",
]
KINDS: Final[tuple[str, ...]] = get_args(Kind)

CONTRACT_VERSION: Final = 1
"""Version of `contactlab.api`. A part made for another version is refused when it is loaded."""


@dataclass(frozen=True)
class Part:
    """One part on offer: enough to list it, and the place to import it from when a scene asks.

    kind       one of `KINDS`
    name       kebab-case, as written in a scene: "mortar-p0"
    target     "package.module:ClassName", imported only when a scene uses the part
    summary    one line for `contactlab parts`
    reference  where the method is published
    api        version of the contract that the part was written for
    """

    kind: Kind
    name: str
    target: str
    summary: str
    reference: str = ""
    api: int = CONTRACT_VERSION
