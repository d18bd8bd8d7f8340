"""Importing the library, when a run is over."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager

LOG = "RUST_LOG"


@contextmanager
def imported_quietly() -> Iterator[None]:
    """Import the library in here: a third faster without garbage collection, and without its word on missing indices.

    What it may say is decided while it is imported. Who has set its variable decides themselves.
    """
    collecting, said = gc.isenabled(), os.environ.get(LOG)
    gc.disable()
    os.environ.setdefault(LOG, "warn,re_log_encoding=error")
    try:
        yield
    finally:
        if said is None:
            del os.environ[LOG]
        if collecting:
            gc.enable()
