"""Reference solutions, against which a comparison measures its runs."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from contactlab.api.arrays import Floats


@dataclass(frozen=True)
class Scalar:
    """A number of a reference solution, with uncertainty `error`; `meaning` describes it in words."""

    value: float
    error: float = 0.0
    meaning: str = ""


@dataclass(frozen=True, eq=False)
class Solution:
    """The contact pressure, and other known numbers, at the end of a scene.

    x            (m,) [mm] deformed positions, increasing
    pressure     (m,) [MPa] there, linear in between and zero outside
    error        of the pressure, relative in L2; NaN if unknown
    error_meaning  method of its estimate
    spread       (m,) [MPa] of the results behind the pressure; empty for none
    window       [mm] over which pressures are compared; None for everywhere
    scalars      by name; "reaction" is the force of the driven support on its body [N/mm]
    level        finest level of our own runs behind it; no run at this level or above is compared with it
    """

    x: Floats
    pressure: Floats
    error: float = math.nan
    error_meaning: str = ""
    spread: Floats | None = None
    window: tuple[float, float] | None = None
    scalars: Mapping[str, Scalar] = field(default_factory=dict)
    level: int | None = None


class ReferenceSolution(ABC):
    """A solution of one scene, or of a family of them. Subclasses are frozen dataclasses without required fields.

    1. `mismatch` gives the reason if it does not apply to a scene: meshes, algorithms and time stepping are free,
       everything that changes the exact solution is not.
    2. `solution` returns the solution of a scene to which it applies, the same in every call.
    3. The pressure carries the reaction: they differ by no more than the stated errors.

    title   one line
    origin  its origin: paper and equation, or program and settings
    """

    title: ClassVar[str]
    origin: ClassVar[str]

    @abstractmethod
    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Return why it does not apply to a scene (its TOML data, with all defaults); empty if it does.

        Never raises, whatever the scene holds.
        """

    @abstractmethod
    def solution(self, scene: Mapping[str, Any]) -> Solution:
        """Return the solution of a scene for which `mismatch` is empty."""

    def examples(self) -> Sequence[Mapping[str, Any]]:
        """Return scenes to which it applies, as plain tables, for checks; by default matching bundled scenes."""
        return ()
