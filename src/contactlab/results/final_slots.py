"""The saved state of a run that is over: it is not taken up again, and only the fields of its end are read.

What else a restart needs is left out; what stays is exact. `final_fields.py` reads it.
"""

from __future__ import annotations

import json

import h5py
import numpy as np

from contactlab.results.checkpoint_slots import CHECKSUM, SERIAL, Slots, header_of
from contactlab.results.checksums import Damage
from contactlab.results.stored_text import write_text

KEPT = ("state.clock", "state.displacement", "state.velocity", "state.history.", "stress.")
"""How names of arrays begin that `FinalFields` and readers of the last step ask for."""
CHUNK = 1 << 14  # numbers


def copy_final(old: h5py.Group, new: h5py.Group, level: int) -> bool:
    """Fill the group `new` from the slots in `old` with the newest state; False where that is not whole."""
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
    text = np.zeros(0, np.uint8)  # the summary of the end is beside it
    counts = np.array([slots.serial, saved.frames, saved.steps, saved.events, len(text)], np.int64)
    header = header_of(counts, flat, text)
    newest = max((0, 1), key=lambda slot: int(slots.headers[slot][SERIAL]))
    for slot in (0, 1):
        place, here = new.create_group(str(slot)), slot == newest
        how = {"chunks": (max(1, min(flat.size, CHUNK)),), "compression": "gzip", "compression_opts": level}
        memory = place.create_dataset("memory", flat.shape, "f8", shuffle=True, **how)
        if here:
            memory[...] = flat
        place.create_dataset("summary", data=text, maxshape=(None,))
        place["header"] = header if here else np.zeros(CHECKSUM + 2, np.int64)
    return True
