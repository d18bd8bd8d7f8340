"""Friction laws: the bound of the tangential force."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from contactlab.api.arrays import Floats

FrictionNeed = Literal["pressure", "slip_rate", "dt", "time", "position", "cell_size", "traction"]
"""Names that a friction law may need in addition to fields of the scene, see `FrictionLaw`."""


class FrictionBound(NamedTuple):
    """|y_t| <= min(adhesion * measure, cap * y_n) + coefficient * y_n: the form in all solvers.

    coefficient [-]   Coulomb: mu; Tresca: 0
    adhesion    [MPa] Tresca's slip bound; Coulomb: 0
    cap         [-]   inf: the adhesion acts on the whole surface; finite: only in contact

    Numbers, or for laws with needs arrays (k,) of k multipliers.
    """

    coefficient: Any
    adhesion: Any
    cap: Any

    def limits(self, normal: Floats, measure: Floats) -> tuple[Floats, Floats]:
        """Return the largest |y_t| (k,) [N] of constraints under normal forces (k,) [N], and its derivatives by them.

        measure  (k,) [mm] of surface of each constraint
        """
        pressed, grip, capped = np.maximum(normal, 0.0), self.adhesion * measure, np.isfinite(self.cap)
        cap = np.where(capped, self.cap, 0.0)
        follows = capped & (cap * pressed < grip)
        growth = self.coefficient + np.where(follows, cap, 0.0)
        return self.coefficient * pressed + np.where(follows, cap * pressed, grip), growth


class FrictionLaw(ABC):
    """A friction law, without geometry. Subclasses are frozen dataclasses; their fields are the TOML keys.

    A law whose bound is not constant declares its variables. Other laws are not affected.

    needs   names of the keywords passed to `bound` and `evolve`, for the k multipliers of a contact:

            pressure   (k,) [MPa], of the last step
            slip_rate  (k,) [mm/s] of this step, with sign; 0 without pressure
            dt         [s] length of this step
            time       [s] at its end
            position   (k, 2) [mm] of the slave nodes in the last step
            cell_size  (k,) [mm] length of slave surface at each, at the start of the run
            traction   (k,) [MPa], the normal stress of the cells behind the slave nodes at the end of the last step,
                       positive in tension
            any other name: (k,) a field of the scene (`[fields]`), such as "temperature", at the end of the step
    memory  names of numbers remembered for each multiplier: further keywords, arrays (k,)

    Bounds follow the resulting rate of slip. Steps are of first order with a law that has needs. At the start
    of a run pressures and rates are zero. A rejected step changes nothing: memory, pressures and rates are part of the
    state.
    """

    needs: ClassVar[tuple[FrictionNeed | str, ...]] = ()
    memory: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def bound(self, *nothing: Any, **needed: Any) -> FrictionBound:
        """Return the law's bound on nodal forces: called once without needs, else several times in every step."""

    def start(self) -> Mapping[str, float]:
        """Return memory at the start of a run, by name; 0 for names that are missing."""
        return {}

    def evolve(self, *nothing: Any, **needed: Any) -> Mapping[str, Any]:
        """Return memory after an accepted step, by name: arrays (k,). Needed by a law with memory."""
        return {}

    @property
    def varies(self) -> bool:
        """True if the bound depends on the motion."""
        return bool(self.needs or self.memory)
