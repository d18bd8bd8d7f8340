"""Progress of a first run before its first step: "compiling kernel 12 of 31"."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from contactlab.run.known_kernels import kernels_of
from contactlab.scene.scene import Scene

UNKNOWN = 30
"""Number of kernels that is assumed for a scene without a known list."""


@contextmanager
def compilation_told(scene: Scene, tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` with a line for each kernel that is compiled, or loaded from the cache, in this block."""
    from contactlab.api.compiled.compiler import COMPILATION

    expected, before = len(kernels_of(scene)) or UNKNOWN, COMPILATION.listener
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
