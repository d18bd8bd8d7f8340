"""Two alternating, checksummed places for what a restart needs.

One of them is always whole: a process that dies while it fills one leaves the other alone.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

import h5py
import numpy as np

from contactlab.api.arrays import Floats
from contactlab.results.checksums import Damage, of_array
from contactlab.results.growing import Column, GrowingFile, fixed
from contactlab.results.stored_text import read_text, write_text

TEXT = 65536  # bytes by which the room for the summary of the run so far grows
SERIAL, FRAMES, STEPS, EVENTS, LENGTH, CHECKSUM, OWN = range(7)


@dataclass(frozen=True)
class Checkpoint:
    """A saved instant: everything a restart needs, and how much of the run was stored by then (`steps`: its last one).

    memory   arrays by name, as `contactlab.model.memory` and the simulation named them
    summary  content of `summary.json` for a run that ends here, as text
    """

    memory: Mapping[str, Floats]
    summary: str
    frames: int
    steps: int
    events: int


class Slots:
    """Two slots for checkpoints: the group `contactlab/checkpoint` of an open file."""

    def __init__(self, group: h5py.Group) -> None:
        self.group = group
        shapes = read_text(group, "arrays") if "arrays" in group else group.attrs["arrays"]
        self.shapes: dict[str, list[int]] = json.loads(shapes)
        self.headers = [group[f"{slot}/header"] for slot in (0, 1)]
        self.memories = [group[f"{slot}/memory"] for slot in (0, 1)]
        self.texts = [Column(group[f"{slot}"], "summary", "u1", together=TEXT) for slot in (0, 1)]
        self.serial = max(int(header[SERIAL]) for header in self.headers)

    @classmethod
    def of(cls, own: h5py.Group) -> Slots | None:
        """The slots of a file that has any."""
        return cls(own["checkpoint"]) if "checkpoint" in own else None

    @classmethod
    def create(cls, own: h5py.Group, memory: Mapping[str, Floats]) -> Slots:
        """Make empty slots for arrays of these names and shapes."""
        group = own.create_group("checkpoint")
        write_text(group, "arrays", json.dumps({name: list(array.shape) for name, array in memory.items()}))
        size = sum(array.size for array in memory.values())
        for slot in ("0", "1"):
            place = group.create_group(slot)
            fixed(place, "memory", (size,), "f8")
            Column(place, "summary", "u1", together=TEXT)
            fixed(place, "header", (7,), "i8")[:] = 0
        return cls(group)

    def write(
        self,
        growing: GrowingFile,
        memory: Mapping[str, Floats],
        summary: str,
        frames: int,
        steps: int,
        events: int,
    ) -> None:
        """Fill the older slot of an open file; its header last."""
        slot = (self.serial + 1) % 2
        flat = np.concatenate([array.ravel() for array in memory.values()])
        text = np.frombuffer(summary.encode(), np.uint8)
        if len(text) > self.texts[slot].room:
            # both, and twice as much as is needed: a summary grows with what happens in the run
            growing.grow(self.texts, TEXT * -(-2 * len(text) // TEXT) - self.texts[slot].room)
        growing.write_around(self.memories[slot], flat)
        self.texts[slot].write(0, text, len(text))
        self.serial += 1
        header = header_of(np.array([self.serial, frames, steps, events, len(text)], np.int64), flat, text)
        self.headers[slot].id.write(h5py.h5s.ALL, h5py.h5s.ALL, header)
        growing.flush()

    def newest(self, frames: int, steps: int, events: int, salvage: bool = False) -> Checkpoint | None:
        """The newest whole checkpoint that needs no more than so many frames, steps and events.

        Raises Damage if the checkpoint written last is damaged; with `salvage` the older checkpoint is used.
        A kill can only leave the older checkpoint half written.
        """
        headers = [header[:] for header in self.headers]
        good = [bool(not header.any() or header[OWN] == of_array(header[:OWN])) for header in headers]
        if not all(good) and not salvage:
            raise Damage("the saved state is damaged")
        slots = sorted((slot for slot in (0, 1) if good[slot]), key=lambda slot: -int(headers[slot][SERIAL]))
        for slot in slots:
            found = self._read(slot)
            if found is None and slot == slots[0] and headers[slot].any() and not salvage:
                raise Damage("the saved state is damaged")
            if found is not None and found.frames <= frames and found.steps <= steps and found.events <= events:
                return found
        return None

    def _read(self, slot: int) -> Checkpoint | None:
        header, flat = self.headers[slot][:], self.memories[slot][:]
        text = self.texts[slot].dataset[: header[LENGTH]]
        if header[SERIAL] == 0 or header[CHECKSUM] != _checksum(flat, text, header[:CHECKSUM]):
            return None
        summary = text.tobytes().decode(errors="ignore")
        arrays, begin = {}, 0
        for name, shape in self.shapes.items():
            size = int(np.prod(shape, dtype=np.int64))
            arrays[name] = flat[begin : begin + size].reshape(shape)
            begin += size
        return Checkpoint(arrays, summary, *(int(header[i]) for i in (FRAMES, STEPS, EVENTS)))


def header_of(counts: np.ndarray, flat: Floats, text: np.ndarray) -> np.ndarray:
    """Counts of a saved state, the checksum of all of it (its arrays one after the other, its summary), and its own."""
    header = np.append(counts, _checksum(flat, text, counts))
    return np.append(header, of_array(header))


def _checksum(flat: Floats, text: np.ndarray, counts: np.ndarray) -> int:
    return zlib.crc32(counts.tobytes(), zlib.crc32(text.tobytes(), zlib.crc32(flat.tobytes())))
