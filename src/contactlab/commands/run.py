"""`contactlab run`: one scene, one run."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from contactlab.commands.common import add_row, console, number, parse_settings, registry_with, table
from contactlab.folders import results_folder
from contactlab.scene import Scene, load_scene

if TYPE_CHECKING:
    from rich.console import Console

    from contactlab.results.results import Results
    from contactlab.simulation import Progress

EXIT_STATUS = {"finished": 0, "refused": 2, "interrupted": 130}
"""Exit status by status of the run; any other is a simulation that failed."""


def run(options: argparse.Namespace) -> int:
    """Run the scene, show how it goes, print a short table."""
    from contactlab.simulation import simulate

    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry).with_(parse_settings(options.settings))
    with results_folder(options.out, scene.name) as folder, shown_progress(scene) as progress:
        results = simulate(scene, out=folder, registry=registry, progress=progress)
    show_results(results, console())
    return EXIT_STATUS.get(results.status, 1)


@contextmanager
def shown_progress(scene: Scene) -> Iterator[Progress]:
    """A bar with step, time and energy error; it stays away where nobody watches."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (
        TextColumn(f"[bold]{scene.name}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %  step {task.fields[step]}  t {task.fields[time]:.3e} s"),
        TextColumn("energy error {task.fields[error]:.1e}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task("run", total=1.0, step=0, time=0.0, error=0.0)

        def show(fraction: float, step: int, time: float, energy_error: float) -> None:
            bar.update(task, completed=fraction, step=step, time=time, error=energy_error)

        yield show


def show_results(results: Results, out: Console) -> None:
    """A short table of one run."""
    summary = results.summary
    shown = table("quantity", "value", title=f"{summary['scene']}: {results.status}")
    for label, value in _rows(summary):
        add_row(shown, label, value)
    out.print(shown)
    if results.reason:
        out.print(f"[bold]{results.status}[/]: ", end="")
        out.print(results.reason, markup=False, highlight=False)
    if results.folder is not None:
        out.print(f"results in {results.folder}", markup=False, highlight=False, soft_wrap=True)


def _rows(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    cost = summary.get("cost", {})
    yield "steps", number(summary["steps"])
    yield "contact sweeps", number(summary["contact_sweeps"])
    if "run_cpu_s" in cost:
        yield "CPU time [s]", number(cost["run_cpu_s"])
    for key, value in summary.get("resolved", {}).items():
        yield f"time.{key}, chosen", number(value)
    for on, force in summary.get("reactions", {}).items():
        yield f"reaction of {on}", _vector(force)
    for name, contact in summary.get("contacts", {}).items():
        yield f"{name} resultant on the slave", _vector(contact["resultant"])
        yield f"{name} pressure integral", _vector(contact["pressure_integral"])
        yield f"{name} largest pressure", number(contact["max_pressure"])
        yield f"{name} largest penetration", number(contact["max_penetration"])
    balance = summary.get("balance", {})
    if balance:
        yield "kinetic energy", number(balance["kinetic"])
        yield "stored energy", number(balance["stored"])


def _vector(force: Any) -> str:
    return "  ".join(number(component) for component in force)
