"""Final `results.vtkhdf` of a finished run, with its tables compressed.

A growing file is not compressed: the index of compressed chunks changes with every row, and a killed process
would leave it half written. When a run ends the whole file is copied once, and the complete copy replaces it.
Data that only a restart needs is left out.
"""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from contactlab.results.checkpoint_slots import CHECKSUM, SERIAL, Slots, header_of
from contactlab.results.checksums import Damage
from contactlab.results.stored_text import write_text

STATE = "/contactlab/checkpoint"
KEPT = ("state.clock", "state.displacement", "state.velocity", "state.history.", "stress.")
"""Prefixes of the arrays that `FinalFields` and readers of the last step use."""
HEADERS = ("v110", "v110")  # an index of chunks takes some 100 bytes instead of 2000, and VTK reads them
LEVEL = 6  # of gzip: 1 saves a fifth of the time and takes 6 % more
SMALL = 512  # bytes of a table that is left in one piece: what describes compressed chunks would be larger
CHUNK = 1 << 15  # numbers of a chunk of what had none
LARGEST = 1 << 17  # bytes of a chunk in which several frames, or many steps, are put together
RECORDS = 1 << 16  # bytes of a chunk of rows with many different numbers: a code for each few of them
AT_ONCE = 3 << 18  # bytes of all chunks that a frame needs: HDF5 keeps 1 MiB of what it has decompressed


def pack(path: Path) -> None:
    """Compress the file at `path`, which nobody writes to.

    If there is no space for a copy it stays as it is.
    """
    packed = path.with_name(path.name + ".packed")
    try:
        with h5py.File(path, "r", locking=False) as old, h5py.File(packed, "w", libver=HEADERS, locking=False) as new:
            _copy_group(old, new, {})
    except OSError:
        with suppress(OSError):
            packed.unlink(missing_ok=True)
        return
    packed.replace(path)


def _copy_group(old: h5py.Group, new: h5py.Group, places: dict[int, str]) -> None:
    """Copy the content of a group; objects with several names in the file, listed in `places`, get them again."""
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
            made = new.create_group(name, track_order=bool(ordered))
            if item.name != STATE or not _copy_state(item, made):
                _copy_group(item, made, places)
        elif item.dtype.kind == "O" or (item.chunks is None and item.nbytes < SMALL):
            h5py.h5o.copy(old.id, name.encode(), new.id, name.encode())
        else:
            _copy_dataset(item, new, name)


def _copy_state(old: h5py.Group, new: h5py.Group) -> bool:
    """Copy the fields of the end from the newest saved state; return False, without a copy, if it is damaged."""
    slots, everything = Slots(old), np.iinfo(np.int64).max
    try:
        saved = slots.newest(everything, everything, everything)
    except Damage:
        return False
    if saved is None:
        return False
    kept = {name: array for name, array in saved.memory.items() if name.startswith(KEPT)}
    write_text(new, "arrays", json.dumps({name: list(array.shape) for name, array in kept.items()}))
    flat = np.concatenate([array.ravel() for array in kept.values()])
    text = np.zeros(0, np.uint8)  # the summary of the end is stored separately
    counts = np.array([slots.serial, saved.frames, saved.steps, saved.events, len(text)], np.int64)
    header = header_of(counts, flat, text)
    newest = max((0, 1), key=lambda slot: int(slots.headers[slot][SERIAL]))
    for slot in (0, 1):
        place, here = new.create_group(str(slot)), slot == newest
        how = {"chunks": (max(1, min(flat.size, CHUNK)),), "compression": "gzip", "compression_opts": LEVEL}
        memory = place.create_dataset("memory", flat.shape, "f8", shuffle=True, **how)
        if here:
            memory[...] = flat
        place.create_dataset("summary", data=text, maxshape=(None,))
        place["header"] = header if here else np.zeros(CHECKSUM + 2, np.int64)
    return True


def _copy_dataset(old: h5py.Dataset, new: h5py.Group, name: str) -> None:
    how = {} if old.nbytes < SMALL else {"dcpl": _compressed(old), "chunks": _chunks(old)}
    made = new.create_dataset(name, old.shape, old.dtype, **how)
    made[...] = old[()]
    _copy_attributes(old, made)


def _compressed(old: h5py.Dataset) -> Any:
    """Creation properties: bytes of equal rank are stored together, in tables of frames across all frames.

    A filter `shuffle` does both. HDF5 sets its size to the size of a number, but for the first filter alone.
    """
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_shuffle()
    frames = old.file["VTKHDF/Steps"].attrs["NSteps"]
    if old.chunks is not None and len(old) == frames * old.chunks[0]:
        plist.set_filter(h5py.h5z.FILTER_SHUFFLE, 0, (int(np.prod(old.chunks[: max(1, old.ndim - 1)])),))
    plist.set_deflate(LEVEL)
    return plist


def _chunks(old: h5py.Dataset) -> tuple[int, ...]:
    """Chunks of one component each, so that similar data is contiguous, over several frames or blocks."""
    if old.chunks is None:
        return (min(old.shape[0], CHUNK), *old.shape[1:])
    if old.dtype.names is not None:
        return (min(old.shape[0], max(1, RECORDS // old.dtype.itemsize)),)
    first, *inner = (max(1, min(pair)) for pair in zip(old.chunks, old.shape, strict=True))
    components = inner[-1] if inner else 1
    row = old.dtype.itemsize * int(np.prod(inner[:-1], dtype=np.int64))
    most = max(1, min(LARGEST, AT_ONCE // components) // (row * first))  # blocks in a chunk
    blocks = -(-old.shape[0] // first)
    together = -(-blocks // -(-blocks // most))  # in equal shares
    return (min(first * together, max(1, old.shape[0])), *inner[:-1], *((1,) if inner else ()))


def _copy_attributes(old: Any, new: Any) -> None:
    for name in old.attrs:
        kept = old.attrs.get_id(name)
        value = np.asarray(old.attrs[name]) if kept.shape else old.attrs[name]
        new.attrs.create(name, value, shape=kept.shape, dtype=kept.dtype)
