"""The file `results.vtkhdf` of a run, opened for reading."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contactlab.errors import RequestError
from contactlab.results.checksums import Damage
from contactlab.results.damage import BROKEN, TABLES
from contactlab.results.journaled import JournaledFile
from contactlab.results.layout_file import READ
from contactlab.results.result_file import FILE


class Foreign(Damage):
    """A file takes something from another one."""


def check_inside(file: Any) -> None:
    """Raise Foreign if a file takes anything from another file: it may be any file of whoever reads it."""
    import h5py

    inside = h5py.h5l.TYPE_HARD, h5py.h5l.TYPE_SOFT

    def look(name: bytes, info: Any) -> bytes | None:
        return None if info.type in inside else name

    if name := file.id.links.visit(look, info=True):
        raise Foreign(f"its {name.decode(errors='replace')} lies in another file")


def check_storage(file: Any) -> None:
    """The same for the numbers of each dataset, which may lie in another file without a link."""
    import h5py

    def look(name: bytes) -> None:
        item = h5py.h5o.open(file.id, name)
        if isinstance(item, h5py.h5d.DatasetID):
            made = item.get_create_plist()
            if made.get_layout() == h5py.h5d.VIRTUAL or made.get_external_count():
                raise Foreign(f"the numbers of {name.decode(errors='replace')} lie in another file")

    h5py.h5o.visit(file.id, look)


def opened(folder: Path) -> Any:
    """The file in `folder`, open for reading. Raises RequestError if that is not possible."""
    import h5py

    path = folder / FILE
    if not path.is_file():
        is_table = (folder / "table.json").is_file()
        found = "the folder has no results.vtkhdf" if folder.is_dir() else "there is no such folder"
        raise RequestError(
            found,
            where=str(folder),
            got=str(folder),
            allowed="the folder of a run whose record.recorders include vtkhdf (the default)",
            hint="load_table reads a comparison; its runs are folders in runs" if is_table else "",
        )
    try:
        over = JournaledFile.read_only(path)
        file = h5py.File(path, "r", locking=False) if over is None else h5py.File(over, "r")
    except OSError as error:
        raise RequestError(f"the file cannot be read: {error}", where=str(path), hint=TABLES) from error
    try:
        check_inside(file)
        ours = "contactlab" in file and "VTKHDF" in file
        version = file["contactlab"].attrs.get("format") if ours else None
    except Foreign as problem:
        file.close()
        raise RequestError(
            f"the file is refused: {problem}", where=str(path), allowed="a file that contains all data of the run"
        ) from problem
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
            hint="read it with the version in its summary.json, or repeat the run from its scene.toml",
        )
    return file
