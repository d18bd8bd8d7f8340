"""`contactlab run`: one scene, one run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING

from contactlab.commands.common import console, parse_settings, print_how_to_look, print_json, registry_with, typed
from contactlab.errors import visible
from contactlab.run.folders import results_folder
from contactlab.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from contactlab.run.simulation import Progress

EXIT_STATUS = {"finished": 0, "refused": 2, "interrupted": 130}
"""Exit status by status of the run; any other status is a failed simulation."""


def run(options: argparse.Namespace) -> int:
    """Run the scene with a progress bar and print a summary."""
    from contactlab.explanation.announcement import announced
    from contactlab.results.result_file import FILE, RESUMABLE
    from contactlab.run.crash import told_if_it_crashes
    from contactlab.run.interruption import Interrupted
    from contactlab.run.simulation import simulate

    registry = registry_with(options.files)
    scene = load_scene(options.scene, registry, parse_settings(options.settings))
    shown = nullcontext() if options.quiet else shown_progress(scene)
    with results_folder(options.out, scene.name, options.resume) as folder, shown as progress:
        try:
            with told_if_it_crashes(folder, scene.name):
                announce = None if options.quiet else announced(sys.stderr if options.json else sys.stdout)
                results = simulate(scene, folder, registry, progress, options.resume, announce=announce)
            status = EXIT_STATUS.get(results.status, 1)
        except Interrupted as stop:
            results, status = stop.results, EXIT_STATUS["interrupted"]
    if options.json:
        print_json({"folder": str(folder), **results.summary})
        return status
    if options.quiet:
        # failure and warnings are all that a quiet run prints
        if results.status != "finished":
            print(visible(f"contactlab: {results.status}: {results.reason}"), file=sys.stderr)
        for warning in results.warnings:
            print(visible(f"contactlab: warning ({warning.code}): {warning.text}"), file=sys.stderr)
        return status
    # libraries that draw tables are needed now, and not before the first step
    from contactlab.reports.run import print_run

    out = console()
    print_run(results, scene.data, out, options.verbose, options.profile)
    print_how_to_look(folder, registry, out)
    if results.status in RESUMABLE and (folder / FILE).exists():
        out.say(f"resume with: {typed('run', options, '--out', str(folder), '--resume')}")
    return status


@contextmanager
def shown_progress(scene: Scene) -> Iterator[Progress | None]:
    """A bar with step, time and energy error; None if the output is not a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    from contactlab.reports.terminal import Terminal
    from contactlab.run.compiling import compilation_told

    columns = (
        TextColumn(scene.name, markup=False, style="bold"),
        BarColumn(bar_width=20),
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Terminal(stderr=True)) as bar:
        task = bar.add_task("building the model", total=1.0)

        def show(fraction: float, step: int, time: float, energy_error: float) -> None:
            words = f"{100.0 * fraction:3.0f} %  step {step}  t {time:.3e}  energy error {energy_error:.0e}"
            bar.update(task, completed=fraction, description=words)

        with compilation_told(scene, lambda line: bar.update(task, description=line)):
            yield show
