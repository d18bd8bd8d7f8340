"""The peak of a run is its own, not that of a larger one before it in the same process."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contactlab.results.peak_memory import peak_memory_mib, reset_peak


@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="peaks can be begun anew on Linux alone")
def test_peak_is_begun_anew() -> None:
    reset_peak()
    base = peak_memory_mib()
    large = np.ones(64 * 2**20 // 8)
    assert peak_memory_mib() > base + 55.0
    del large
    reset_peak()
    assert peak_memory_mib() < base + 16.0  # 64 MiB were there and are gone
