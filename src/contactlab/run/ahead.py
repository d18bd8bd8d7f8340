"""Kernels that other processes compile ahead, while this process compiles the kernels that it calls first.

A first run compiles some thirty kernels one after the other, each when it is called; a few of them take most of the
time. If some of these are not in the cache, parallel processes compile them, the longest first, as far as the machine
has cores. A run that gets to such a kernel waits until it is done, and loads it.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.parts.machine import usable_cores
from contactlab.run.known_kernels import KnownKernel, surely_called
from contactlab.scene.scene import Scene

if TYPE_CHECKING:
    from subprocess import Popen

MOST = 3
"""Processes that compile in parallel to a run: the longest kernel alone takes a fourth of the time of all."""
FEWEST = 2
"""Kernels that are worth a process: it takes a second to begin."""
_processes: list[Popen[bytes]] = []
os.register_at_fork(after_in_child=_processes.clear)  # they are the parent's to wait for


def compile_ahead(scene: Scene) -> None:
    """Have the kernels compiled that a run of this scene is likely to call and that are not in the cache."""
    _compile(tuple(kernel for kernel in surely_called(scene) if kernel.types))


@cache
def _compile(kernels: Sequence[KnownKernel]) -> None:
    """Start to compile the kernels that are not in the cache, once in a process."""
    missing = sorted((kernel for kernel in kernels if _is_missing(kernel)), key=lambda kernel: -kernel.seconds)
    if len(missing) >= FEWEST:
        _start(missing, min(len(missing), MOST, usable_cores() - 1))


def _is_missing(kernel: KnownKernel) -> bool:
    """Return whether no machine code of a kernel is on the disk, without importing its module."""
    from contactlab.api.compiled.cache import cache_folder

    package, *inner = kernel.module.split(".")
    found = find_spec(package)  # of a module within it, `find_spec` would import what is around
    if found is None or not found.submodule_search_locations:
        return False
    file = Path(found.submodule_search_locations[0], *inner).with_suffix(".py")
    return not any(Path(cache_folder(str(file))).glob(f"*/{inner[-1]}.{kernel.name}-*.nbi"))


def _start(kernels: Sequence[KnownKernel], count: int) -> None:
    import subprocess

    words = json.dumps(kernels), str(usable_cores() - 1)
    path = os.pathsep.join(entry for entry in sys.path if entry)
    for _ in range(count):
        with suppress(OSError):
            process = subprocess.Popen(
                [sys.executable, "-P", "-m", "contactlab.run.compile_listed", *words],
                env={**os.environ, "PYTHONPATH": path}, start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            _processes.append(process)


def wait_for_all() -> None:
    """Wait until the processes that compile ahead are done."""
    while _processes:
        _processes.pop().wait()


@atexit.register
def _end_all() -> None:
    """Kill the processes that still compile when a run ends; kernels that are stored stay in the cache."""
    for process in _processes:
        process.kill()
    wait_for_all()
