"""`contactlab.choose`, `error_budget`, `matrix`, `explain` and `check`: commands as functions that return objects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from numbers import Integral, Real
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contactlab.accuracy.choose import Chosen, Wish, choose_plan
from contactlab.accuracy.error_budget import ErrorBudget, budget_plan
from contactlab.arguments import NAME, arguments
from contactlab.errors import RequestError
from contactlab.explanation.explain import Explanation
from contactlab.explanation.explain import explain as explanation_of
from contactlab.explanation.kept import trials, tried
from contactlab.jobs.driver import Driver
from contactlab.jobs.scheduler import LOCAL
from contactlab.parts.registry import Registry, default_registry
from contactlab.reports.progress import progress_of
from contactlab.run.attempts import first_that_fits
from contactlab.run.folders import results_folder
from contactlab.scene.scene import Scene, load_scene
from contactlab.testing.check_part import PartReport, check_part
from contactlab.testing.find import subjects
from contactlab.verdicts.files import write_folder
from contactlab.verdicts.plan import Request
from contactlab.verdicts.run import Matrix, run_matrix

_MANY: dict[str, Any] = {
    "out": NAME, "jobs": Integral, "registry": Registry, "resume": bool, "time_limit": Real, "scheduler": str,
    "progress": bool,
}  # fmt: skip


@arguments(scene=(Scene, *NAME), error=Real, budget=Real, search=Real, **_MANY)
def choose(
    scene: Scene | str | Path,
    error: float = 0.01,
    *,
    budget: float = 60.0,
    search: float = 120.0,
    out: str | Path | None = None,
    jobs: int | None = None,
    registry: Registry | None = None,
    resume: bool = False,
    time_limit: float | None = None,
    scheduler: str = LOCAL,
    progress: bool | None = None,
) -> Chosen:
    """Find the cheapest algorithm, element and mesh that reach a pressure error.

    scene       a scene, the name of a bundled scene, or a TOML file
    error       relative error of the contact pressure to reach
    budget      CPU time that the chosen run may take [s]
    search      CPU time that all trials together may take [s]
    out         folder that keeps the trials for `resume`; none: no files
    jobs        runs at a time; one per core by default
    time_limit  wall time of one trial [s]
    scheduler   "local", "dask" or tcp://HOST:PORT of a dask scheduler

    `Chosen.choice` are the keys for `scene.with_`; `Chosen.verdict` is "ok" if they keep the error with all that is
    uncertain, else "cannot": then they are the best that is known, and `Chosen.why` says what was judged.
    Raises RequestError for a wrong request, KeyboardInterrupt after Ctrl-C; finished trials stay in `out`.
    """
    own = _scene(scene, registry)
    wish = Wish(float(error), float(budget), float(search))
    with _driver(out, resume, jobs, scheduler, time_limit, progress) as driver:
        found: Chosen = driver.result(choose_plan(own, wish, registry or default_registry(), driver.progress.told))
    return found


@arguments(scene=(Scene, *NAME), **_MANY)
def error_budget(
    scene: Scene | str | Path,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    registry: Registry | None = None,
    resume: bool = False,
    time_limit: float | None = None,
    scheduler: str = LOCAL,
    progress: bool | None = None,
) -> ErrorBudget:
    """Estimate the parts of the error of a run: mesh, load increments, ramp, enforcement, each halved in turn.

    scene  a scene, the name of a bundled scene, or a TOML file; for the other arguments see `choose`

    `ErrorBudget.shares` is empty if the run as it is does not finish; `reason` says why.
    Raises RequestError for a wrong request, KeyboardInterrupt after Ctrl-C; finished runs stay in `out`.
    """
    own = _scene(scene, registry)
    with _driver(out, resume, jobs, scheduler, time_limit, progress) as driver:
        found: ErrorBudget = driver.result(budget_plan(own, registry or default_registry(), driver.progress.told))
    return found


@arguments(cases=Sequence, contacts=Sequence, levels=Sequence, full=bool, **_MANY)
def matrix(
    cases: Sequence[str] = (),
    contacts: Sequence[str] = (),
    *,
    levels: Sequence[int] = (1,),
    full: bool = False,
    out: str | Path | None = None,
    jobs: int | None = None,
    registry: Registry | None = None,
    resume: bool = False,
    time_limit: float | None = None,
    scheduler: str = LOCAL,
    progress: bool | None = None,
) -> Matrix:
    """Judge contact algorithms by benchmark cases with known solutions.

    cases     names of cases; all that are installed by default
    contacts  names of contact algorithms; all by default
    levels    of mesh refinement
    full      either slave, all elements, integrators and variants of the cases, too

    For the other arguments see `choose`. A folder `out` gets the files of the command.
    Raises RequestError for a wrong request, KeyboardInterrupt after Ctrl-C; finished cells stay in `out`.
    """
    request = Request(tuple(cases), tuple(contacts), full, tuple(dict.fromkeys(levels)))
    with _driver(out, resume, jobs, scheduler, time_limit, progress) as driver:
        found = run_matrix(request, registry or default_registry(), driver)
    if out is not None:
        assert driver.folder is not None
        write_folder(found, driver.folder)
    return found


@arguments(scene=(Scene, *NAME), registry=Registry)
def explain(scene: Scene | str | Path, *, registry: Registry | None = None) -> Explanation:
    """Say what a scene calls for, what it does not, and what a run of it will cost.

    scene  a scene, the name of a bundled scene, or a TOML file

    The first steps of the scene are run in a process of their own, for a fifth of its cost; they are kept, and not run
    again. `Explanation.price` has CPU time [s], an interval, steps, iterations and memory [MiB].
    Raises RequestError for a wrong scene, SimulationFailure if its first steps fail.
    """
    own = _scene(scene, registry)
    own, order = first_that_fits(own, own.registry)
    with trials() as archive:
        return explanation_of(own, own.registry, tried(own, archive), order)


@arguments(target=NAME, kind=str, files=Sequence, settings=Mapping, only=Sequence)
def check(
    target: str | Path,
    kind: str = "",
    *,
    files: Sequence[str] = (),
    settings: Mapping[str, Any] | None = None,
    only: Sequence[str] = (),
) -> list[PartReport]:
    """Validate plugin components: unit checks, cases with known solutions, cost of a call.

    target    name of a component, Python file or folder of a package
    kind      "contact", "material" ... if the name belongs to several kinds
    files     further Python files with components
    settings  values of its fields
    only      names of checks; all by default

    Returns a report for each component; `report.right` if nothing failed, `report.outcomes` with a reason each.
    Raises RequestError if no component of this name is found.
    """
    return [check_part(subject, only=list(only)) for subject in subjects(str(target), kind, files, settings)]


def _scene(scene: Scene | str | Path, registry: Registry | None) -> Scene:
    return scene if isinstance(scene, Scene) else load_scene(scene, registry)


@contextmanager
def _driver(
    out: str | Path | None,
    resume: bool,
    jobs: int | None,
    scheduler: str,
    time_limit: float | None,
    progress: bool | None,
) -> Iterator[Driver]:
    """Start a driver in `out` or in a temporary folder. Raises KeyboardInterrupt if it was interrupted."""
    with ExitStack() as stack:
        if out is not None:
            folder = stack.enter_context(results_folder(out, "", resume))
        elif resume:
            raise RequestError("runs can only be resumed in their folder", where="resume", allowed="out = a folder")
        else:
            folder = Path(stack.enter_context(TemporaryDirectory()))
        shown = progress_of(None, progress)
        driver = stack.enter_context(Driver(folder, jobs, scheduler, time_limit, shown))
        yield driver
        if driver.interrupted:
            raise KeyboardInterrupt
