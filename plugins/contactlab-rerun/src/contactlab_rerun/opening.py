"""Step at which a recording opens: a property of it, as the library's views cannot name an instant."""

from __future__ import annotations

import warnings
from pathlib import Path

OPENS = "opens"


def step_to_open(file: Path) -> int | None:
    """The step that the recording names; None if it names none."""
    from rerun.chunk import RrdReader

    with warnings.catch_warnings(action="ignore"):  # it has no index
        chunks = RrdReader(str(file)).stream().filter(content=f"/__properties/{OPENS}/**")
    for chunk in chunks:
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if name.rpartition(":")[2] == "step" or name == "step":
                return int(batch.column(name)[0][0].as_py())
    return None
