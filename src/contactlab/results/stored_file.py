"""The file `results.vtkhdf` of a run, opened for reading."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contactlab.errors import RequestError
from contactlab.results.damage import BROKEN, TABLES
from contactlab.results.layout_file import READ
from contactlab.results.result_file import FILE


def opened(folder: Path) -> Any:
    """The file in `folder`, open for reading. Raises RequestError where that is not possible."""
    import h5py

    path = folder / FILE
    if not path.is_file():
        found = "the folder has no results.vtkhdf" if folder.is_dir() else "there is no such folder"
        raise RequestError(
            found, where=str(folder), allowed="the folder of a run whose record.recorders include vtkhdf (the default)"
        )
    try:
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        raise RequestError(f"the file cannot be read: {error}", where=str(path), hint=TABLES) from error
    try:
        ours = "contactlab" in file and "VTKHDF" in file
        version = file["contactlab"].attrs.get("format") if ours else None
    except BROKEN:
        ours = False
    if not ours:
        file.close()
        raise RequestError(
            "the file was not written by contactlab, or its headers are damaged", where=str(path), hint=TABLES
        )
    if version not in READ:
        file.close()
        raise RequestError(
            "the file was written by another version of contactlab",
            where=str(path),
            got=f"format {version}",
            allowed=f"format {' or '.join(map(str, READ))}",
            hint="read it with the version in its summary.json, or make the run again from its scene.toml",
        )
    return file
