"""Results read back from `results.vtkhdf`, by h5py and NumPy alone."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from contactlab.api.arrays import Floats
from contactlab.api.frame import ContactCurve, Iterate, IterationRow
from contactlab.api.thinning import Thinning
from contactlab.arguments import NAME, arguments
from contactlab.errors import RequestError, one_line
from contactlab.results.checkpoint_slots import Checkpoint, Slots
from contactlab.results.checksums import GROUP, Damage, of_rows
from contactlab.results.contact_table import recorded, recorded_up_to, stored_record
from contactlab.results.damage import BROKEN, TABLES, check_all, damage_told, whole_frames
from contactlab.results.event_table import read_events
from contactlab.results.final_fields import FinalFields
from contactlab.results.frame_sums import StoredSums
from contactlab.results.iterate_table import StoredIterates, check_iterates
from contactlab.results.iteration_table import read_iterations
from contactlab.results.last_steps_file import stored_last_steps
from contactlab.results.layout_file import read_layout
from contactlab.results.result_file import FILE
from contactlab.results.results import ContactHistory, Results
from contactlab.results.stored_file import check_storage, opened
from contactlab.results.stored_frames import StoredFrames
from contactlab.results.stored_rows import StoredRows, up_to
from contactlab.results.stored_text import read_columns, read_text
from contactlab.results.thinned_table import pieces_of, thinning_of

T = TypeVar("T")


@arguments(folder=NAME, salvage=bool)
def load_results(folder: str | Path, salvage: bool = False) -> Results:
    """Load the results of the run in `folder`, equal to those of `simulate`; as far as it went if it was killed.

    With `salvage` a damaged file gives all undamaged data: damaged frames, rows of tables and steps are left out,
    and `Results.lost` names what is missing. Raises RequestError if there is no readable `results.vtkhdf`, and,
    without `salvage`, if something in it is damaged; frames and steps are checked when they are read.
    """
    folder = Path(folder)
    with opened(folder) as file:
        if salvage:
            try:
                return _Reader(file, folder, salvage).results()
            except BROKEN as problem:
                raise RequestError(
                    f"the file cannot be read: {one_line(problem)}", where=str(folder / FILE), hint=TABLES
                ) from problem
        with damage_told(folder):
            return _Reader(file, folder).results()


def load_checkpoint(folder: Path) -> tuple[Results, Checkpoint] | None:
    """The newest checkpoint in `folder` and the run up to it; None if nothing was saved before the run stopped.

    Raises RequestError if anything up to there is damaged.
    """
    with opened(folder) as file, damage_told(folder):
        reader = _Reader(file, folder)
        if reader.checkpoint is None:
            return None
        reader.limit(reader.checkpoint)
        check_all(file, reader.layout, reader.frames)
        run = reader.results()
        for rows in (run.step_source, *(run.contact[c.name].step_source for c in reader.layout.contacts)):
            cast(StoredRows, rows).check(reader.own)
        check_iterates(reader.own, len(run.iterations))
        return run, reader.checkpoint


class _Reader:
    """Reader of an open file. With `salvage` damaged data is left out, and `lost` lists it."""

    def __init__(self, file: Any, folder: Path, salvage: bool = False) -> None:
        check_storage(file)
        self.file, self.folder, self.own = file, folder, file["contactlab"]
        self.salvage = salvage
        self.lost: list[str] = []
        self.layout = read_layout(self.own)
        self.frames = self._or("the frames", lambda: _frame_count(file, salvage), 0)
        nothing: list[tuple[int, int]] = []
        self.steps = self._or("the steps", lambda: pieces_of(self.own["steps"]), nothing)
        self.recorded = self._or("the contact record", lambda: recorded(self.own, self.layout), nothing)
        self.events = self._or("the events", lambda: len(self.own["events/step"]), 0)
        self.last_step = math.inf
        slots = self._or("the saved state", lambda: Slots.of(self.own), None)
        self.checkpoint = self._or("the saved state", lambda: self._newest(slots), None)
        saved = slots.serial if slots is not None else 0
        # the summary of a run that was resumed belongs to an earlier end
        self.closed = "summary" in self.own and int(self.own["summary"].attrs.get("serial", saved)) >= saved
        self.sums = self._or("the frames", lambda: StoredSums(self.own), None) if self.frames else None
        self.numbers = self._numbers()

    def _newest(self, slots: Slots | None) -> Checkpoint | None:
        last = [end for begin, end in self.steps if end > begin][-1:]
        steps = int(self.own["steps"][last[0] - 1, 0]) if last else 0
        return slots.newest(self.frames, steps, self.events, self.salvage) if slots is not None else None

    def _or(self, what: str, read: Callable[[], T], otherwise: T) -> T:
        """Return the result of `read`; with `salvage` `otherwise` if it fails."""
        if not self.salvage:
            return read()
        try:
            return read()
        except BROKEN:
            self.lost.append(what)
            return otherwise

    def _numbers(self) -> list[int]:
        """Numbers of the frames that are read."""
        if not self.salvage:
            return list(range(self.frames))
        found = whole_frames(self.file, self.layout, self.sums, self.frames) if self.sums is not None else []
        self.lost += [f"frame {number}" for number in sorted(set(range(self.frames)) - set(found))]
        return found

    def limit(self, checkpoint: Checkpoint) -> None:
        """See no more than was stored when the checkpoint was made."""
        self.frames, self.events = checkpoint.frames, checkpoint.events
        self.closed = False  # a run may end later than its last saved state, as on a full disk
        self.numbers = self.numbers[: self.frames]
        self.last_step = float(checkpoint.memory["state.clock"][1])
        self.steps = up_to(self.steps, lambda row: int(self.own["steps"][row, 0]), self.last_step)
        self.recorded = recorded_up_to(self.own, self.layout, self.recorded, self.last_step)

    def results(self) -> Results:
        """Read all that the file holds into one `Results`."""
        contact = self._contacts()
        frames = StoredFrames(self.folder, self.layout, self.numbers)
        end = FinalFields(self.layout, self.checkpoint, frames)
        columns = len(self.layout.steps)
        thinning = self._or("the steps", lambda: thinning_of(self.own["steps"]), Thinning())
        steps = StoredRows(
            self.folder, "steps", f"{GROUP}/steps", of_rows, np.dtype("f8"), self.steps, thinning, self.salvage, columns
        )
        if self.salvage and (missing := steps.total - sum(len(block) for block in steps)):
            self.lost.append(f"{missing} of {steps.total} steps")
        iterations = self._or(
            "the iterations", lambda: read_iterations(self.own, self.last_step, self.salvage), list[IterationRow]()
        )
        return Results(
            summary=self._or("the summary", self._summary, self._unsaved_summary()),
            layout=self.layout,
            history=self._history(),
            contact=contact | {c.label: contact[c.name] for c in self.layout.contacts},
            displacement=end.displacement,
            velocity=end.velocity,
            stress=end.stress,
            internal_variables=end.internal_variables,
            events=self._or("the events", lambda: read_events(self.own, self.events, self.salvage), []),
            iterations=iterations,
            iterates=self._iterates(len(iterations)),
            frames=frames,
            last_steps=stored_last_steps(self.folder),
            folder=self.folder,
            step_source=steps,
            closed=self.closed,
            lost=tuple(self.lost),
        )

    def _iterates(self, iterations: int) -> Sequence[Iterate]:
        def read() -> Sequence[Iterate]:
            return StoredIterates(self.folder, self.own, iterations, self.salvage)

        return self._or("displacements of iterations", read, ())

    def _summary(self) -> dict[str, Any]:
        """Return the summary of the end, or of the last checkpoint if the run did not end."""
        if self.closed:
            text = read_text(self.own, "summary")
        elif self.checkpoint is not None and self.checkpoint.summary:
            text = self.checkpoint.summary
        elif (self.folder / "summary.json").is_file():
            text = (self.folder / "summary.json").read_text()
        else:
            return self._unsaved_summary()
        summary: dict[str, Any] = json.loads(text)
        return summary

    def _unsaved_summary(self) -> dict[str, Any]:
        """Return a summary of a run that was killed before it saved its first state."""
        return {
            "format": 1,
            "scene": self.layout.title,
            "status": "interrupted",
            "reason": "the run ended without a message before its first state was saved",
            "parts": dict(self.layout.parts),
            "versions": dict(self.layout.versions),
            "steps": sum(end - begin for begin, end in self.steps),
        }

    def _rows(self, name: str, table: Any) -> Floats:
        """The rows of a table that belong to the frames that are read, each as it was written."""
        values = np.asarray(table[: self.frames])[self.numbers]
        if self.sums is not None and not self.salvage:
            for number, row in zip(self.numbers, values, strict=True):
                self.sums.check(number, name, row)
        return values

    def _history(self) -> dict[str, Floats]:
        if "history" not in self.own or not self.numbers:
            return {}
        values = self._rows("history", self.own["history"])
        return {name: values[:, i].copy() for i, name in enumerate(read_columns(self.own, "history"))}

    def _contacts(self) -> dict[str, ContactHistory]:
        times = self._history().get("time", np.zeros(0)).tolist()
        found = {}
        for contact in self.layout.contacts:
            table = self._rows(f"curves of {contact.name}", self.own[f"contacts/{contact.name}/curves"])
            record = stored_record(self.own, self.folder, self.layout, contact, self.recorded, self.salvage)
            curves = [ContactCurve.of_table(values.T, contact.memory) for values in table]
            found[contact.name] = ContactHistory(list(times), curves, record)
        return found


def _frame_count(file: Any, salvage: bool) -> int:
    steps = file["VTKHDF/Steps"]
    count, times = int(steps.attrs["NSteps"]), steps["Values"][:]
    if salvage:
        return min(count, len(file["contactlab/history"])) if count else 0
    if len(times) != count or (count and not np.array_equal(times, _times(file["contactlab"], count))):
        raise Damage("the times of the frames are damaged")
    return count


def _times(own: Any, count: int) -> Floats:
    return np.asarray(own["history"][:count, read_columns(own, "history").index("time")])
