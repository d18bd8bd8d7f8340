"""Events in `results.vtkhdf`: few, so they are appended one by one."""

from __future__ import annotations

import h5py
import numpy as np

from contactlab.api.frame import Event
from contactlab.results.checksums import Damage, of_text
from contactlab.results.growing import GrowingFile

SUM = "checksum"
WORDS = "words"
_KINDS = {"step": "i8", "time": "f8", "level": "S8", "end": "i8", SUM: "u4"}
OLD = "text"  # format 3: a dataset of texts of variable length


class EventTable:
    """The group `contactlab/events` of an open file.

    A dataset per number or short word of an event, all texts one after the other as bytes in `words`, and in `end` the
    byte after each.
    """

    def __init__(self, growing: GrowingFile, own: h5py.Group) -> None:
        self.growing = growing
        self.group = own.require_group("events")
        old = _rows(self.group, None) if OLD in self.group else []
        if OLD in self.group:
            self.group.clear()
        if WORDS not in self.group:
            for name, kind in _KINDS.items():
                self.group.create_dataset(name, (0,), maxshape=(None,), dtype=kind, chunks=(64,))
            self.group.create_dataset(WORDS, (0,), maxshape=(None,), dtype="u1", chunks=(4096,))
        for event, _ in old:
            self.add(event)

    @property
    def count(self) -> int:
        """Number of events that are stored."""
        return len(self.group["step"])

    def add(self, event: Event) -> None:
        """Append one event to the table."""
        count, begin = self.count, len(self.group[WORDS])
        text = np.frombuffer(event.text.encode(), np.uint8)
        self._resize(count + 1, begin + len(text))
        self.group[WORDS][begin:] = text
        row = (event.step, event.time, event.level, begin + len(text), of_text(*_stored(event)))
        for name, value in zip(_KINDS, row, strict=True):
            self.group[name][count] = value
        self.growing.flush()

    def cut(self, count: int) -> None:
        """Drop all events after the first `count`."""
        self._resize(count, int(self.group["end"][count - 1]) if count else 0)

    def _resize(self, count: int, size: int) -> None:
        for name in (*_KINDS, WORDS):
            self.group[name].resize(size if name == WORDS else count, 0)


def _stored(event: Event) -> tuple[int, float, str, str]:
    return int(event.step), float(event.time), str(event.level)[:8], str(event.text)


def _rows(group: h5py.Group, count: int | None) -> list[tuple[Event, int]]:
    """Read the first `count` events (None: all), each with the checksum that it had when it was written."""
    steps, times, levels, sums = (group[name][:count].tolist() for name in ("step", "time", "level", SUM))
    if OLD in group:
        texts = group[OLD][:count].tolist()
    else:
        words, ends = group[WORDS][:].tobytes(), group["end"][:count].tolist()
        texts = [words[max(0, begin) : max(0, end)] for begin, end in zip([0, *ends], ends, strict=False)]
    events = [
        Event(int(step), float(time), level.decode(errors="replace"), text.decode(errors="replace"))
        for step, time, level, text in zip(steps, times, levels, texts, strict=True)
    ]
    return list(zip(events, sums, strict=True))


def read_events(own: h5py.Group, count: int, salvage: bool = False) -> list[Event]:
    """Read the first `count` events of the group `contactlab`.

    Raises Damage if one is damaged; with `salvage` such events are left out.
    """
    rows = _rows(own["events"], count)
    good = [event for event, known in rows if of_text(*_stored(event)) == known]
    if len(good) < len(rows) and not salvage:
        raise Damage(f"{len(rows) - len(good)} of {len(rows)} events are damaged")
    return good
