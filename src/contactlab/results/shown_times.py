"""The times of the frames as VTK sees them, updated atomically.

VTK takes the number of frames from an attribute and their times from an array, and needs both to agree: it reads a
missing time as 0, and writes a surplus time beyond its memory. Both cannot be changed in one write. So there are two
groups that share all else; the hidden group is updated and written out, and then a single link changes over.
"""

from __future__ import annotations

import h5py
import numpy as np

from contactlab.api.arrays import Floats
from contactlab.results.growing import GrowingFile, Number, early

CHUNK = 8192
LINK = "contactlab/shown/frames"
_GROUPS = ("contactlab/frames/0", "contactlab/frames/1")


def create_times(file: h5py.File) -> h5py.Group:
    """Create both groups, with `VTKHDF/Steps` as the visible group; return the first. `ShownTimes` fills both."""
    for name in _GROUPS:
        group = file.create_group(name)
        group.attrs["NSteps"] = np.int64(0)
        group.create_dataset("Values", (0,), maxshape=(None,), dtype="f8", chunks=(CHUNK,), dcpl=early())
    file.create_group("contactlab/shown", track_order=True)["frames"] = file[_GROUPS[0]]
    file["VTKHDF/Steps"] = h5py.SoftLink(f"/{LINK}")
    return file[_GROUPS[0]]


class ShownTimes:
    """The two groups of an open file. `count` frames are shown."""

    def __init__(self, growing: GrowingFile) -> None:
        self.growing = growing
        groups = [growing.file[name] for name in _GROUPS]
        for name in groups[0]:
            if name not in groups[1]:
                groups[1][name] = groups[0][name]
        self.numbers = [Number(group, "NSteps") for group in groups]
        self.values = [group["Values"] for group in groups]
        self.groups, self.links = groups, growing.file["contactlab/shown"]
        self.shown = 1 if self.links["frames"] == groups[1] else 0
        self.times: Floats = self.values[self.shown][:]

    @property
    def count(self) -> int:
        """Number of frames that readers see."""
        return self.numbers[self.shown].value

    def append(self, time: float) -> None:
        """Show one more frame; all that belongs to it has been written."""
        self._show(np.append(self.times, time))

    def cut(self, count: int) -> None:
        """Let readers see exactly `count` frames."""
        self._show(self.times[:count].copy())

    def _show(self, times: Floats) -> None:
        other = 1 - self.shown
        self.values[other].id.set_extent((len(times),))
        if len(times):
            self.values[other].id.write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(times))
        self.numbers[other].write(len(times))
        self.growing.flush()
        self.links.id.unlink(b"frames")
        h5py.h5o.link(self.groups[other].id, self.links.id, b"frames")
        self.shown, self.times = other, times
        self.growing.flush()
