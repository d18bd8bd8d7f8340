"""The largest memory of a run, and not of what its process did before."""

from __future__ import annotations

import ctypes
import gc
import sys
from contextlib import suppress
from pathlib import Path

GARBAGE = 16.0  # MiB above what was needed last: a search for garbage costs as much as a small run's steps
_needed: float | None = None
_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def reset_peak() -> None:
    """Forget the peak so far and give back what the process holds but does not use; on Linux alone."""
    global _needed
    if _needed is not None:  # the first run has nothing to clear away
        _trim()
        if _status("VmRSS") > _needed + GARBAGE:
            gc.collect()
            _trim()
    with suppress(OSError, ValueError):
        _needed = _status("VmRSS")
        _RESET.write_text("5")


def _trim() -> None:
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _status(key: str) -> float:
    """A size that the system reports for this process [MiB]."""
    (found,) = (line.split()[1] for line in _STATUS.read_text().splitlines() if line.startswith(f"{key}:"))
    return float(found) / 1024.0


def peak_memory_mib() -> float:
    """Largest memory of this process since `reset_peak` [MiB]; elsewhere than on Linux since it began."""
    try:
        return _status("VmHWM")
    except (OSError, ValueError):
        import resource

        unit = 1024.0 if sys.platform != "darwin" else 1048576.0
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
