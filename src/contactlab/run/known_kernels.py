"""The kernels that a scene will call, as far as it is like one whose kernels are known (data/known_kernels.json)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from contactlab.parts.provenance import part_specs
from contactlab.scene.scene import Scene


class KnownKernel(NamedTuple):
    """A kernel by its module and name.

    types    of its arguments in numba's words ("i8, f8[:,::1]"); empty for kernels that compile quickly
    seconds  that it takes to compile, roughly
    """

    module: str
    name: str
    types: str
    seconds: float


def kernels_of(scene: Scene) -> Sequence[KnownKernel]:
    """Return kernels of the known scene with the most similar parts, in the order of their first call; may be empty."""
    own = used_parts(scene)
    likeness = {parts: len(own & parts) / len(own | parts) for parts in _known()}
    best = max(likeness, key=lambda parts: (likeness[parts], len(_known()[parts])), default=frozenset[str]())
    return _known()[best] if likeness.get(best, 0.0) > 0.0 else ()


def surely_called(scene: Scene) -> Sequence[KnownKernel]:
    """Return kernels of the largest known scene whose parts are all used here too: nearly all of them are needed."""
    own = used_parts(scene)
    return max((kernels for parts, kernels in _known().items() if parts <= own), key=len, default=())


def used_parts(scene: Scene) -> frozenset[str]:
    """Names of the parts whose kernels are called, all but meshes and recorders, and the kind of contact forces."""
    parts = {name for _, kind, name in part_specs(scene) if kind not in ("mesh", "recorder")}
    frozen = scene.integrator.get("forces") in ("frozen", "published")
    return frozenset(parts | {"frozen forces" if frozen else "forces"})


@cache
def _known() -> dict[frozenset[str], Sequence[KnownKernel]]:
    data = json.loads((files("contactlab") / "data" / "known_kernels.json").read_text(encoding="utf-8"))

    def kernel(name: str) -> KnownKernel:
        facts = data["kernels"].get(name, {"types": "", "seconds": 0.0})
        module, _, function = name.rpartition(".")
        return KnownKernel(module, function, **facts)

    return {frozenset(entry["parts"]): [kernel(name) for name in entry["kernels"]] for entry in data["scenes"].values()}
