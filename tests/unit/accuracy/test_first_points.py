"""Nothing delays the first points of a study: what draws its page is imported while they are computed."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar

import pytest

from contactlab.accuracy import run
from contactlab.accuracy.study import CaseChoice, CaseStudy, Contender
from contactlab.parts.registry import default_registry
from contactlab.studies.call import Call, Pool
from contactlab.studies.pool import ProcessDiedError

PROGRAM = """
import sys
import contactlab.commands.accuracy
from contactlab.commands.accuracy_progress import import_what_draws
late = {"matplotlib", "bokeh", "scipy.optimize", "scipy.stats", "numba"}
print(sorted(late & set(sys.modules)))
import_what_draws()
print("matplotlib" in sys.modules)
"""


class Losing(Pool):
    """Every call dies at once."""

    elsewhere: ClassVar[bool] = False

    def __init__(self, heard: list[str]) -> None:
        self.heard = heard

    def submit(self, call: Call) -> Future[Any]:
        """A future that has failed."""
        self.heard.append("submitted")
        lost: Future[Any] = Future()
        lost.set_exception(ProcessDiedError("gone"))
        return lost

    def stop(self) -> None:
        """Nothing runs."""

    def kill(self) -> None:
        """Nothing runs."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing to wait for."""


@pytest.mark.parametrize("jobs", [1, 2])
def test_there_is_time_for_something_else_once_when_the_first_points_are_on_their_way(
    jobs: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[str] = []
    monkeypatch.setattr(run, "open_pool", lambda scheduler, jobs: Losing(heard))
    algorithms = ("mortar-p0", "mortar-p1", "node-on-segment")
    contenders = tuple(Contender(f"statics, {use}", "q1", "newton", use) for use in algorithms)
    study = CaseStudy((CaseChoice(use="hertz"),), contenders, levels=(1,), join=False)
    run.run_accuracy(
        study, default_registry(), tmp_path, jobs, lambda *told: heard.append("told"),
        meanwhile=lambda: heard.append("meanwhile"),
    )  # fmt: skip
    assert heard[: jobs + 2] == [*["submitted"] * jobs, "meanwhile", "told"]
    assert heard.count("meanwhile") == 1
    assert heard.count("told") == heard.count("submitted") >= len(contenders)


def test_a_study_begins_without_libraries_that_draw_or_fit() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == ["[]", "True"], done.stderr
