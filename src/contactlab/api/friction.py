"""Friction laws: the bound of the tangential force."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple


class FrictionBound(NamedTuple):
    """|y_t| <= min(adhesion * measure, cap * y_n) + coefficient * y_n: the form that all solvers use.

    coefficient [-]   Coulomb: mu; Tresca: 0
    adhesion    [MPa] Tresca's slip bound; Coulomb: 0
    cap         [-]   inf: the adhesion acts on the whole surface; finite: only where contact is closed
    """

    coefficient: float
    adhesion: float
    cap: float


class FrictionLaw(ABC):
    """A friction law, without geometry. Subclasses are frozen dataclasses; their fields are the TOML keys."""

    @abstractmethod
    def bound(self) -> FrictionBound:
        """The law's bound on nodal forces."""
