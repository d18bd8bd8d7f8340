"""`contactlab run`: one scene, one run. docs/theory/README.md lists the files from here to the contact forces."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING

from contactlab.commands.common import (
    console,
    parse_settings,
    print_how_to_look,
    print_json,
    registry_with,
    resume_line,
)
from contactlab.errors import visible
from contactlab.run.folders import results_folder
from contactlab.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from rich.progress import ProgressColumn

    from contactlab.run.simulation import Progress

WORDS = len("100 %  step 123456  t 2.86e-06  energy error 1e-15")
CLOCK = len("0:00:00")
SHORTEST_BAR = 4
"""Characters of a progress bar."""

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
        out.say(f"resume with: {resume_line(options, folder)}")
    return status


@contextmanager
def shown_progress(scene: Scene) -> Iterator[Progress | None]:
    """A bar with step, time and energy error; None if the output is not a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import Progress

    from contactlab.reports.terminal import Terminal
    from contactlab.run.compiling import compilation_told

    console = Terminal(stderr=True)
    with Progress(*progress_columns(scene.name, console.width), console=console) as bar:
        task = bar.add_task("building the model", total=1.0)

        def show(fraction: float, step: int, time: float, energy_error: float) -> None:
            words = f"{100.0 * fraction:3.0f} %  step {step}  t {time:.2e}  energy error {energy_error:.0e}"
            bar.update(task, completed=fraction, description=words)

        with compilation_told(scene, lambda line: bar.update(task, description=line)):
            yield show


def progress_columns(name: str, width: int) -> list[ProgressColumn]:
    """Name, bar, words, time elapsed and remaining: the bar has what the others leave of the width, up to 20."""
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    room = width - WORDS - 2 * CLOCK - 3  # gaps
    bar = min(20, room - len(name) - 1)
    shown = name if len(name) <= room else f"{name[: max(0, room - 3)]}..."
    bars: list[ProgressColumn] = [BarColumn(bar_width=bar)] if bar >= SHORTEST_BAR else []
    words = TextColumn("{task.description}", markup=False)
    return [TextColumn(shown, markup=False, style="bold"), *bars, words, TimeElapsedColumn(), TimeRemainingColumn()]
