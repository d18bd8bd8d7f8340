"""A process that compiles kernels for another one: `python -m ... [[module, name, types, seconds], ...] places`.

It takes them in their order, leaves out those that another process has in hand, and ends with the process that started
it. Of all such processes on a machine, whoever started them, no more than `places` compile.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import json
import os
import signal
import sys
from contextlib import suppress
from importlib import import_module
from typing import Any

from contactlab.api.compiled.cache import cache_root
from contactlab.api.compiled.locks import free_place, kernel_locked

_END_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux


def main() -> None:
    """Compile what the command line names."""
    atexit.register(gc.freeze)  # nobody looks for garbage in a process that ends
    parent = os.getppid()
    with suppress(OSError, AttributeError):  # other systems: looked at between kernels
        ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)
    place = free_place(cache_root(), int(sys.argv[2]))
    if place is None:
        return
    with place:
        for module, name, types, _ in json.loads(sys.argv[1]):
            if os.getppid() != parent:
                return
            # errors here are found, and reported, by the run that calls the kernel
            with suppress(Exception):
                _compile(module, name, types)


def signature(types: str) -> tuple[Any, ...]:
    """Types in numba's words, or a table's name, as numba wants them: "i8, FactoredRows, f8[::1]"."""
    types_of: Any = import_module("numba.core.sigutils").normalize_signature
    contract, unpack = import_module("contactlab.api"), import_module("contactlab.api.compiled.unpack")
    given: list[Any] = []
    for word in types.split(", "):
        table = getattr(contract, word, None)
        given += types_of(f"({word},)")[0] if table is None else [unpack.Table(table)]
    return tuple(given)


def _compile(module: str, name: str, types: str) -> None:
    kernel: Any = getattr(import_module(module), name)
    with kernel_locked(kernel, wait=False) as free:
        if free:
            kernel.compile(signature(types))


if __name__ == "__main__":
    main()
