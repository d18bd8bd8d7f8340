"""The largest memory of a run, and not of what its process did before."""

from __future__ import annotations

import ctypes
import gc
import sys
from contextlib import suppress
from pathlib import Path

_runs = 0
_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def reset_peak() -> None:
    """Forget the peak so far and give back what the process holds but does not use; on Linux alone."""
    global _runs
    _runs += 1
    if _runs > 1:  # the first has nothing to clear away
        gc.collect()
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).malloc_trim(0)
    with suppress(OSError):
        _RESET.write_text("5")


def peak_memory_mib() -> float:
    """Largest memory of this process since `reset_peak` [MiB]; elsewhere than on Linux since it began."""
    try:
        lines = _STATUS.read_text().splitlines()
        (peak,) = (line.split()[1] for line in lines if line.startswith("VmHWM:"))
        return float(peak) / 1024.0
    except (OSError, ValueError):
        import resource

        unit = 1024.0 if sys.platform != "darwin" else 1048576.0
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
