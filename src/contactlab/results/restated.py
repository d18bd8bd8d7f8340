"""Another summary for a run that is stored."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from contactlab.results.files import write_summary
from contactlab.results.result_file import FILE


def restate(folder: Path, summary: Mapping[str, Any]) -> None:
    """Give the finished run in `folder` this summary, in `results.vtkhdf` if there is one and in `summary.json`."""
    if (folder / FILE).is_file():
        import h5py

        from contactlab.results.stored_text import write_text

        with h5py.File(folder / FILE, "r+") as file:
            own = file["contactlab"]
            serial = own["summary"].attrs["serial"]
            del own["summary"]
            write_text(own, "summary", json.dumps(summary)).attrs["serial"] = serial
    write_summary(folder, summary)
