"""The references in `data/references` as parts, which come by entry point as all parts do."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

from contactlab.api import ReferenceSolution, Scalar, Solution
from contactlab.studies.reference import FOLDER, Reference, load_reference


class StoredReference(ReferenceSolution):
    """A reference in a JSON file of `data/references` with the CSV file of its curve. Subclasses name it.

    name  of its files
    """

    name: ClassVar[str]

    def __init_subclass__(cls) -> None:
        """Take title and origin from the file."""
        content = json.loads((FOLDER / f"{cls.name}.json").read_text(encoding="utf-8"))
        cls.title, cls.origin = str(content["title"]), str(content["origin"])

    @property
    def stored(self) -> Reference:
        """Return the content of the files."""
        return _read(self.name)

    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """Every key under `holds_for` must have its value."""
        return self.stored.mismatch(scene)

    def solution(self, scene: Mapping[str, Any]) -> Solution:
        """The curve and the scalars of the file."""
        found = self.stored
        scalars = {
            name: Scalar(float(s["value"]), float(s["error"]), str(s.get("meaning", "")))
            for name, s in found.scalars.items()
        }
        meaning = str(found.error_estimate.get("meaning", ""))
        pressure = found.profile.x, found.profile.value, found.pressure_uncertainty, meaning
        return Solution(*pressure, found.spread, found.window, scalars, found.level)


_read = cache(load_reference)


@dataclass(frozen=True)
class DiscOnBlockDeep(StoredReference):
    """disc-on-block at the depth of the paper, from the project's own static runs on fine meshes."""

    name: ClassVar[str] = "disc-on-block-deep"


@dataclass(frozen=True)
class DiscOnBlockShallow(StoredReference):
    """disc-on-block at a depth of 0.01 mm, from the project's own static runs on fine meshes."""

    name: ClassVar[str] = "disc-on-block-shallow"
