"""Choice of the reference of a run: the one that a study names, else the first installed one that fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from contactlab.api import ReferenceSolution
from contactlab.errors import PartError, Where, one_line
from contactlab.parts.registry import Registry, default_registry
from contactlab.studies.profile import Profile
from contactlab.studies.reference import Reference, load_reference


class Source(Protocol):
    """Source of solutions for some scenes: the file of a reference, or a part of kind reference."""

    @property
    def name(self) -> str:
        """Name in studies and tables."""
        ...

    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Return why it does not hold for a scene; empty if it holds."""
        ...

    def at(self, scene: Mapping[str, Any]) -> Reference:
        """The solution of a scene that it holds for."""
        ...


@dataclass(frozen=True)
class PartSource:
    """A part of kind reference."""

    name: str
    part: ReferenceSolution

    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Return the part's own reason; a part that raises holds for no scene."""
        try:
            return str(self.part.mismatch(scene))
        except Exception as error:
            return f"the reference {self.name} raised {one_line(error)}"

    def at(self, scene: Mapping[str, Any]) -> Reference:
        """The solution of the part. Raises PartError for one that cannot be compared with."""
        try:
            found = self.part.solution(scene)
            x, pressure = np.asarray(found.x, float), np.asarray(found.pressure, float)
            if x.ndim != 1 or x.shape != pressure.shape or len(x) < 2:
                raise ValueError(
                    f"x and pressure have the shapes {x.shape} and {pressure.shape}, needed: both (n,), n >= 2"
                )
            if np.any(np.diff(x) <= 0.0) or not np.all(np.isfinite(pressure)):
                raise ValueError("x must increase and pressures must be finite")
        except Exception as error:
            text = f"the reference {self.name} has no usable solution: {one_line(error)}"
            raise PartError(text, where=f"reference {self.name}") from error
        spread = np.zeros(len(found.x)) if found.spread is None else np.asarray(found.spread, float)
        return Reference(
            name=self.name,
            title=self.part.title,
            origin=self.part.origin,
            profile=Profile(np.asarray(found.x, float), np.asarray(found.pressure, float)),
            spread=spread,
            window=found.window,
            scalars={name: vars(scalar) for name, scalar in found.scalars.items()},
            error_estimate={"pressure": found.error, "meaning": found.error_meaning},
            level=found.level,
        )


def find_reference(name: str, registry: Registry, beside: Path | None = None, where: Where = "reference") -> Source:
    """An installed reference by its name, or the path of a JSON file. Raises RequestError if it does not exist."""
    if name in registry.names("reference"):
        return PartSource(name, registry.make("reference", name, where))
    return load_reference(name, beside=beside, where=where, known=registry.names("reference"))


def matching_reference(scene: Mapping[str, Any], registry: Registry | None = None) -> Reference | None:
    """The solution of the first installed reference that holds for the scene (its TOML data)."""
    registry = registry or default_registry()
    for name in registry.names("reference"):
        source = find_reference(name, registry)
        if not source.mismatch(scene):
            return source.at(scene)
    return None
