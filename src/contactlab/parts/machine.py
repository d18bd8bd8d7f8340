"""The machine: its processor, cores, and the kernels and threads of BLAS; last digits of a run depend on some of it."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


@cache
def processor() -> str:
    """The processor by its own name and by the target of its machine code, as "AMD EPYC (znver4)"."""
    from llvmlite.binding import get_host_cpu_name

    return f"{processor_name()} ({get_host_cpu_name()})"


def usable_cores() -> int:
    """Number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def processor_name() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def blas_kernels() -> str:
    """Library and kernels of each BLAS that is loaded, as "openblas SkylakeX"; NumPy and SciPy bring one each."""
    named = (f"{library['internal_api']} {library.get('architecture', '')}".strip() for library in _blas().info())
    return "; ".join(dict.fromkeys(named)) or "not known"


def with_one_blas_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with BLAS on one thread: sums that threads share depend on how many there are."""

    @wraps(function)
    def limited(*arguments: P.args, **named: P.kwargs) -> R:
        with _blas().limit(limits=1):
            return function(*arguments, **named)

    return limited


def _blas() -> Any:
    return _loaded("scipy.linalg" in sys.modules)


@cache
def _loaded(scipy: bool) -> Any:
    """The libraries as they are now; asking costs as much as some steps, so it is done when SciPy's may be new."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(user_api="blas")
