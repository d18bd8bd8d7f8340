"""`integrator = "auto"`: a run starts again with each integrator of the order until one gets through.

Results of an attempt that did not get through go to the folder `attempts` of the run. If none does, the results that
got furthest are the results of the run, and its reason names all.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from contactlab.errors import RequestError, SimulationFailure
from contactlab.results.files import write_summary
from contactlab.results.result_file import FILE
from contactlab.results.results import Results
from contactlab.run.attempts import FINISHED, Attempt, Attempts, candidates, comes_short
from contactlab.run.folders import ATTEMPTS, OF_A_RUN
from contactlab.run.restart import differences_to, refuse_other_scene, saved_run
from contactlab.scene.auto import AUTO, is_auto
from contactlab.scene.scene import Scene

SUMMARY = "summary.json"
RunOne = Callable[["Scene", bool, Attempts], Results]
"""Starts or resumes a run of a scene with one integrator."""


class InOrder:
    """The runs of one scene with `integrator = "auto"`.

    scene    its order of integrators
    folder   of the run; None without files
    run      makes one of the runs
    stopped  whether nobody wants another one
    """

    def __init__(self, scene: Scene, folder: Path | None, run: RunOne, stopped: Callable[[], bool]) -> None:
        self.scenes, self.folder, self.run, self.stopped = candidates(scene), folder, run, stopped
        self.attempts = Attempts(scene.integrator["order"])
        self.before = {path.name for path in folder.iterdir()} - set(OF_A_RUN) if folder is not None else set()
        self.kept: dict[int, Results] = {}  # of attempts without files that can be read, by the integrator's number
        self.error: Exception | None = None  # of the first that could not begin

    def results(self, resume: bool) -> Results:
        """Make runs until one gets through; with `resume` continue from the saved run in the folder.

        Raises the first error if no run could begin.
        """
        begin = self._take_up(self.folder) if resume and self.folder is not None else None
        going, begin = begin is not None, begin or 0
        for number in range(begin, len(self.scenes)):
            if (found := self._attempt(number, going and number == begin)) is not None:
                return found
        return self._furthest()

    def _attempt(self, number: int, going: bool) -> Results | None:
        """Make the run with one integrator; None if it came short."""
        scene, place = self.scenes[number], self._place(number)
        use = str(scene.integrator["use"])
        if not going and place is not None and (place / SUMMARY).is_file():  # of a run that was killed later
            self._read(number, place)
            return None
        try:
            results = self.run(scene, going, self.attempts)
        except (RequestError, SimulationFailure) as error:
            self.error = self.error or error
            self.attempts.tried.append(Attempt.of_error(use, error))
            return None
        short = comes_short(results.summary)
        if self.stopped() or not short or results.summary["resolved"].get("integrator", {}).get("furthest"):
            return results
        if place is not None:
            assert self.folder is not None
            place.mkdir(parents=True, exist_ok=True)
            own = {path.name for path in self.folder.iterdir()} - self.before - {ATTEMPTS}
            _move(self.folder, place, sorted(own, key=lambda name: name == FILE))
        if place is None or not (place / FILE).is_file():
            self.kept[number] = results
        self.attempts.add(use, results.summary, short, f"{ATTEMPTS}/{place.name}" if place is not None else "")
        return None

    def _furthest(self) -> Results:
        """Return the results of the attempt that got furthest. Raises the first error if there are none."""
        tried, cost = self.attempts.tried, self.attempts.cost
        made = [number for number, attempt in enumerate(tried) if attempt.reached]
        if not made:
            assert self.error is not None
            raise self.error
        best = max(made, key=lambda number: tried[number].progress)
        chosen, results = tried.pop(best), self.kept.get(best)
        place = self._place(best)
        if place is not None and self.folder is not None:
            names = sorted((path.name for path in place.iterdir()), key=lambda name: name != FILE)
            _move(place, self.folder, names)
            place.rmdir()
            results = results or _stored(self.folder)
        assert results is not None
        own: dict[str, Any] = {**results.summary, "resolved": {**results.summary["resolved"]}}
        own["resolved"]["integrator"] = {**self.attempts.resolved(chosen.use), "furthest": True}
        own["cost"] = {**cost, "failed_attempts_s": self.attempts.cpu_s}
        if results.status != FINISHED:
            others = "; ".join(attempt.brief for attempt in tried)
            own["reason"] = f"{chosen.use}, which got furthest: {chosen.reason}; the others: {others}"
        if self.folder is not None:
            restate(self.folder, own)
        return replace(results, summary=own)

    def _name(self, number: int) -> str:
        return f"{number + 1}-{self.scenes[number].integrator['use']}"

    def _place(self, number: int) -> Path | None:
        return None if self.folder is None else self.folder / ATTEMPTS / self._name(number)

    def _read(self, number: int, place: Path) -> None:
        """Take in an attempt whose results lie at its place."""
        summary = json.loads((place / SUMMARY).read_text(encoding="utf-8"))
        self.attempts.take_up(summary)
        use = str(self.scenes[number].integrator["use"])
        self.attempts.add(use, summary, comes_short(summary), f"{ATTEMPTS}/{place.name}")

    def _take_up(self, folder: Path) -> int | None:
        """Number of the integrator whose run is saved in the folder, with the attempts before; None without any.

        Raises RequestError if the folder holds a run of another scene.
        """
        if (stored := _stored(folder)) is None:
            return None
        found = [number for number, scene in enumerate(self.scenes) if not differences_to(stored.layout.scene, scene)]
        if not found:
            refuse_other_scene(stored.layout.scene, self.scenes[0], folder)
        self.attempts.take_up(stored.summary)
        return found[0]


def as_begun(scene: Scene, folder: Path) -> Scene:
    """The scene with the order of integrators that the run in the folder was begun with, if it is one of its runs."""
    stored = None if is_auto(scene.integrator) else _stored(folder)
    found = stored.summary.get("resolved", {}).get("integrator") if stored is not None else None
    if stored is None or found is None or differences_to(stored.layout.scene, scene):
        return scene
    return replace(scene, integrator={"use": AUTO, "order": found["order"]})


def _stored(folder: Path) -> Results | None:
    """The run in the folder, None without any."""
    if not (folder / FILE).is_file():
        return None
    from contactlab.results.load import load_results

    try:
        return load_results(folder)
    except RequestError:  # damaged behind what was saved last, or up to there, which raises the same
        saved = saved_run(folder)
        return saved[0] if saved is not None else None


def _move(source: Path, target: Path, names: list[str]) -> None:
    """Move files in this order: a process that replaces a killed one continues where `results.vtkhdf` is."""
    for name in names:
        (source / name).rename(target / name)


def restate(folder: Path, summary: Mapping[str, Any]) -> None:
    """Give the finished run in `folder` this summary, in `results.vtkhdf` if there is one and in `summary.json`."""
    if (folder / FILE).is_file():
        import h5py

        from contactlab.results.stored_text import write_text

        with h5py.File(folder / FILE, "r+") as file:
            own = file["contactlab"]
            serial = own["summary"].attrs["serial"]
            del own["summary"]
            write_text(own, "summary", json.dumps(summary)).attrs["serial"] = serial
    write_summary(folder, summary)
