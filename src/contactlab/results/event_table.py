"""Events in `results.vtkhdf`: few, so they are appended one by one."""

from __future__ import annotations

import h5py

from contactlab.api.frame import Event
from contactlab.results.checksums import Damage, of_text
from contactlab.results.growing import GrowingFile

SUM = "checksum"
_KINDS = {"step": "i8", "time": "f8", "level": "S8", "text": h5py.string_dtype()}


class EventTable:
    """The group `contactlab/events` of an open file: one dataset per field of `Event`."""

    def __init__(self, growing: GrowingFile, own: h5py.Group) -> None:
        self.growing = growing
        self.group = own.require_group("events")
        for name, kind in _KINDS.items():
            if name not in self.group:
                self.group.create_dataset(name, (0,), maxshape=(None,), dtype=kind, chunks=(64,))
        if SUM not in self.group:
            self.group.create_dataset(SUM, (0,), maxshape=(None,), dtype="u4", chunks=(64,))

    @property
    def count(self) -> int:
        """Number of events that are stored."""
        return len(self.group["step"])

    def add(self, event: Event) -> None:
        """Append one event to the table."""
        count = self.count
        self.growing.reserve(len(event.text.encode()))
        self.cut(count + 1)
        for name, value in zip(_KINDS, event, strict=True):
            self.group[name][count] = value
        self.group[SUM][count] = of_text(*_stored(event))
        self.growing.flush()

    def cut(self, count: int) -> None:
        """Drop all events after the first `count`."""
        for name in (*_KINDS, SUM):
            self.group[name].resize(count, 0)


def _stored(event: Event) -> tuple[int, float, str, str]:
    return int(event.step), float(event.time), str(event.level)[:8], str(event.text)


def read_events(own: h5py.Group, count: int, salvage: bool = False) -> list[Event]:
    """Read the first `count` events of the group `contactlab`.

    Raises Damage where one is not as it was written; with `salvage` such events are left out.
    """
    group = own["events"]
    columns = [group[name][:count] for name in _KINDS]
    events = [
        Event(int(step), float(time), level.decode(errors="replace"), text.decode(errors="replace"))
        for step, time, level, text in zip(*columns, strict=True)
    ]
    sums = group[SUM][:count].tolist()
    good = [event for event, known in zip(events, sums, strict=True) if of_text(*_stored(event)) == known]
    if len(good) < len(events) and not salvage:
        raise Damage(f"{len(events) - len(good)} of {len(events)} events are damaged")
    return good
