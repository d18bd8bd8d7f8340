"""A `results.vtkhdf` to which nothing will be added any more, with its tables compressed.

A file that grows is not compressed: what tells where compressed chunks lie changes with every row, and a killed process
would leave it half written. When a run is over the whole file is copied once, and the copy
takes its place when it is whole.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from contactlab.results.checkpoint_slots import SERIAL
from contactlab.results.growing import HEADERS

LEVEL = 1  # of gzip: higher ones are slower and save 2 %
SMALL = 4096  # bytes of a table that is left as it is: what describes compressed chunks would be larger
CHUNK = 1 << 15  # numbers of a chunk of what had none


def pack(path: Path, least: int = 0) -> None:
    """Compress the file at `path`, which nobody writes to, if it has `least` bytes.

    Where there is no room for a copy it stays as it is.
    """
    packed = path.with_name(path.name + ".packed")
    try:
        if path.stat().st_size < least:
            return
        with h5py.File(path, "r", locking=False) as old, h5py.File(packed, "w", libver=HEADERS, locking=False) as new:
            _copy_group(old, new, {})
    except OSError:
        with suppress(OSError):
            packed.unlink(missing_ok=True)
        return
    packed.replace(path)


def _copy_group(old: h5py.Group, new: h5py.Group, places: dict[int, str]) -> None:
    """Copy what is in a group; what has several names in the file, as `places` tell, gets them again."""
    _copy_attributes(old, new)
    for name in old:
        link = old.get(name, getlink=True)
        if isinstance(link, h5py.SoftLink):
            new[name] = h5py.SoftLink(link.path)
            continue
        item = old[name]
        address = h5py.h5o.get_info(item.id).addr
        if address in places:
            new[name] = new.file[places[address]]
            continue
        places[address] = item.name
        if isinstance(item, h5py.Group):
            ordered = item.id.get_create_plist().get_link_creation_order()
            _copy_group(item, new.create_group(name, track_order=bool(ordered)), places)
        else:
            _copy_dataset(item, new, name)


def _copy_dataset(old: h5py.Dataset, new: h5py.Group, name: str) -> None:
    how: dict[str, Any] = {}
    if old.chunks is not None:
        chunks = tuple(max(1, min(pair)) for pair in zip(old.chunks, old.shape, strict=True))
        how = {"maxshape": old.maxshape, "chunks": chunks}
    if old.nbytes >= SMALL and old.dtype.kind != "O":
        chunks = how.get("chunks") or (min(old.shape[0], CHUNK), *old.shape[1:])
        how |= {"chunks": chunks, "compression": "gzip", "compression_opts": LEVEL, "shuffle": True}
    made = new.create_dataset(name, old.shape, old.dtype, **how)
    if not _outdated(old):
        made[...] = old[()]
    _copy_attributes(old, made)


def _outdated(dataset: h5py.Dataset) -> bool:
    """Whether this is the memory of the older one of two saved states: only the newer one is of use any more."""
    slot = dataset.parent
    if not dataset.name.endswith("/memory") or "header" not in slot:
        return False
    slots = {name: other for name, other in slot.parent.items() if isinstance(other, h5py.Group)}
    serials = {name: int(other["header"][SERIAL]) for name, other in slots.items()}
    return serials[slot.name.rpartition("/")[2]] < max(serials.values())


def _copy_attributes(old: Any, new: Any) -> None:
    for name in old.attrs:
        kept = old.attrs.get_id(name)
        value = np.asarray(old.attrs[name]) if kept.shape else old.attrs[name]
        new.attrs.create(name, value, shape=kept.shape, dtype=kept.dtype)
