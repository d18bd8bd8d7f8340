"""Facts about the machine and the libraries, kept in every row with its CPU seconds."""

from __future__ import annotations

import platform
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from contactlab.parts.machine import processor_name, usable_cores

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


@cache
def commit() -> str:
    """Commit of the sources, with "-dirty" after changes; empty without a checkout or without git."""
    words = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--exclude=*"]
    try:
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def machine() -> str:
    """Name and kind of this machine, as rows of an archive carry it."""
    return f"{platform.node()} {platform.system()} {platform.machine()}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
