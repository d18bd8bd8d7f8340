"""Reference solutions: what a comparison measures its runs against."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from contactlab.api.arrays import Floats


@dataclass(frozen=True)
class Scalar:
    """A number of a reference solution, known to +-`error`; `meaning` says in words what it is."""

    value: float
    error: float = 0.0
    meaning: str = ""


@dataclass(frozen=True, eq=False)
class Solution:
    """A contact pressure and what else is known of the end of a scene.

    x            (m,) [mm] deformed positions, increasing
    pressure     (m,) [MPa] there, with straight lines between and none outside
    error        of the pressure, relative in L2; nan where it is not known
    error_meaning  how it was estimated
    spread       (m,) [MPa] of the results behind the pressure; empty for none
    window       [mm] over which pressures are compared; None for everywhere
    scalars      by name; "reaction" is the force of the driven support on its body [N/mm]
    """

    x: Floats
    pressure: Floats
    error: float = math.nan
    error_meaning: str = ""
    spread: Floats | None = None
    window: tuple[float, float] | None = None
    scalars: Mapping[str, Scalar] = field(default_factory=dict)


class ReferenceSolution(ABC):
    """A solution of one scene, or of a family of them. Subclasses are frozen dataclasses without required fields.

    1. `mismatch` says why it is silent about a scene; meshes, algorithms and time stepping are free, everything that
       changes the exact solution is not.
    2. `solution` gives the solution of a scene that it holds for; the same each time it is asked.
    3. The pressure carries the reaction: their difference lies within the errors that are told.

    title   one line
    origin  where it comes from: paper and equation, or program and settings
    """

    title: ClassVar[str]
    origin: ClassVar[str]

    @abstractmethod
    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Why it says nothing about a scene (its TOML data, defaults written out); empty where it holds.

        Never raises, whatever the scene holds.
        """

    @abstractmethod
    def solution(self, scene: Mapping[str, Any]) -> Solution:
        """The solution of a scene for which `mismatch` is empty."""
