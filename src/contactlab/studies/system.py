"""Facts about the machine and the libraries, kept in every row beside its CPU seconds."""

from __future__ import annotations

import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from contactlab.parts.machine import processor_name

_LIBRARIES = ("contactlab", "numpy", "numba")


@cache
def system_facts() -> dict[str, str | int]:
    """Processor, cores on offer, operating system, versions of Python and of what computes."""
    return {
        "processor": processor_name(),
        "cores": usable_cores(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: _version(name) for name in _LIBRARIES},
    }


def machine() -> str:
    """Name and kind of this machine, as rows of an archive carry it."""
    return f"{platform.node()} {platform.system()} {platform.machine()}"


def usable_cores() -> int:
    """Number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
