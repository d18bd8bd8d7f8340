"""What must be known of the file of results where nothing is stored: nobody imports HDF5 for a name."""

from __future__ import annotations

FILE = "results.vtkhdf"
RESUMABLE = ("interrupted", "timed-out", "failed")
"""A failed run is taken up where it was saved: what failed may be mended, a full disk say."""
