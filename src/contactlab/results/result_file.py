"""Names of the file of results, without an import of HDF5."""

from __future__ import annotations

FILE = "results.vtkhdf"
RESUMABLE = ("interrupted", "timed-out", "failed")
"""A failed run is resumed where it was saved: the cause may be repaired, such as a full disk."""
