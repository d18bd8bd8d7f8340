"""What a first run is doing before its first step: "compiling kernel 12 of 31"."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from contactlab.parts.provenance import part_specs

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene

UNKNOWN = 30
"""Kernels of a scene that is like no other."""


@contextmanager
def compilation_told(scene: Scene, tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` with a line for each kernel that is compiled, or loaded from the cache, in this block."""
    from contactlab.api.compiled.kernel import COMPILATION

    expected, before = expected_kernels(scene), COMPILATION.listener
    kernels: list[Any] = []

    def listen(kernel: Any) -> None:
        doing = "preparing" if not kernels else "compiling" if kernels[-1].stats.cache_misses else "loading"
        kernels.append(kernel)
        tell(f"{doing} kernel {len(kernels)} of {max(expected, len(kernels))}")

    COMPILATION.listener = listen
    try:
        yield
    finally:
        COMPILATION.listener = before


def expected_kernels(scene: Scene) -> int:
    """How many kernels a run of the scene calls: as many as the bundled scene whose parts are most like its own."""
    own = used_parts(scene)
    likeness = {count: len(own & parts) / len(own | parts) for parts, count in _known()}
    best = max(likeness, key=lambda count: (likeness[count], count), default=UNKNOWN)
    return best if likeness.get(best, 0.0) > 0.0 else UNKNOWN


def used_parts(scene: Scene) -> frozenset[str]:
    """Names of the parts that decide which kernels are called: all but meshes and recorders."""
    return frozenset(name for _, kind, name in part_specs(scene) if kind not in ("mesh", "recorder"))


@cache
def _known() -> list[tuple[frozenset[str], int]]:
    text = (files("contactlab") / "data" / "kernel_counts.json").read_text(encoding="utf-8")
    return [(frozenset(entry["parts"]), int(entry["kernels"])) for entry in json.loads(text).values()]
