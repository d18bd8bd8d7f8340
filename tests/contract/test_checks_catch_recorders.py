"""Every check of recorders catches a planted defect, and a right one passes all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from contactlab.api import Floats, Frame, Layout, Recorder, Recording
from contactlab.results.vtkhdf import VtkHdf
from contactlab.testing import recorder
from contactlab.testing.assertions import Check


class Lines(Recording):
    """Times of frames and steps in a text file."""

    def __init__(self, flaw: str, folder: Path, lines: list[str]) -> None:
        self.flaw, self.folder, self.lines = flaw, folder, lines

    def steps(self, block: Floats) -> None:
        self.lines += [f"{row}" for row in block]

    def frame(self, frame: Frame) -> None:
        if self.flaw == "leaves the last frame out" and frame.number == 3:
            return
        if self.flaw == "scales in place":
            frame.displacement[:] *= 1000.0
        if self.flaw == "one body for all":
            self.lines.append(f"{next(iter(frame.cells.values()))['von_mises'].max():.3f}")
        self.lines.append(f"{frame.time:.3f} {np.abs(frame.displacement).max():.3f}")

    def close(self, summary: Mapping[str, Any]) -> None:
        if self.flaw == "needs a frame":
            self.lines[0] = "# " + self.lines[0]
        if self.flaw == "writes beside":
            (self.folder.parent / "lines.txt").write_text("\n".join(self.lines))
        name = "line.txt" if self.flaw == "another name" else "lines.txt"
        if self.flaw != "forgets to write":
            (self.folder / name).write_text("\n".join(self.lines))


KEPT: list[str] = []


@dataclass(frozen=True)
class Text(Recorder):
    """A recorder as simple as can be; one flaw or none."""

    flaw: str = ""
    every_step: ClassVar[bool] = True
    shown_file: ClassVar[str] = "lines.txt"

    def open(self, folder: Path, layout: Layout) -> Recording:
        return Lines(self.flaw, folder, KEPT if self.flaw == "one list for all" else [])


@pytest.mark.parametrize("check", recorder.CHECKS)
def test_a_right_recorder_passes(check: Check) -> None:
    check(Text())


class Halved(Recording):
    """What the shipped recorder writes, of displacements half as large."""

    def __init__(self, inner: Recording) -> None:
        self.inner = inner

    def steps(self, block: Floats) -> None:
        self.inner.steps(block)

    def frame(self, frame: Frame) -> None:
        self.inner.frame(replace(frame, displacement=0.5 * frame.displacement))

    def close(self, summary: Mapping[str, Any]) -> None:
        self.inner.close(summary)


@dataclass(frozen=True)
class Halving(VtkHdf):
    def open(self, folder: Path, layout: Layout) -> Recording:
        return Halved(super().open(folder, layout))


WRONG: list[tuple[Check, Recorder, bool]] = [
    (recorder.leaves_something, Text("forgets to write"), False),
    (recorder.leaves_something, Text("writes beside"), False),
    (recorder.leaves_something, Text("another name"), False),
    (recorder.changes_nothing, Text("scales in place"), False),
    (recorder.closes_after_a_failure, Text("needs a frame"), True),
    (recorder.everything_leaves_a_trace, Text("leaves the last frame out"), False),
    (recorder.records_twice, Text("one list for all"), False),
    (recorder.is_read_back, Halving(), False),
    (recorder.bodies_are_told_apart, Text("one body for all"), False),
]


@pytest.mark.parametrize(("check", "part", "raises"), WRONG)
def test_wrong_recorders_are_caught(caught: Any, check: Check, part: Recorder, raises: bool) -> None:
    caught(check, part, raises=raises)


def test_every_check_has_a_wrong_part() -> None:
    assert {check for check, _, _ in WRONG} == set(recorder.CHECKS)
