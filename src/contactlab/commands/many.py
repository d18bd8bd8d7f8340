"""Common functions of commands that make many runs: folder, driver, progress, and messages after Ctrl-C."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.commands.common import resume_line
from contactlab.errors import visible

if TYPE_CHECKING:
    from contactlab.jobs.driver import Driver

INTERRUPTED = 130
"""Exit status."""


@contextmanager
def many(options: argparse.Namespace, name: str, total: int | None = None) -> Iterator[Driver]:
    """A driver as the options ask for it, with its folder and its progress of `total` results."""
    from contactlab.jobs.driver import Driver
    from contactlab.reports.progress import progress_of
    from contactlab.run.folders import results_folder

    with results_folder(options.out, name, options.resume) as folder:
        progress = progress_of(total, show=True)
        with Driver(folder, options.jobs, options.scheduler, options.time_limit, progress) as driver:
            yield driver


def folder_of(driver: Driver) -> Path:
    """The folder of a driver that has one."""
    assert driver.folder is not None
    return driver.folder


def interrupted(options: argparse.Namespace, folder: Path) -> int:
    """Say how to resume in `folder`; returns the exit status."""
    line = f"interrupted; resume with: {resume_line(options, folder)}"
    print(visible(line), file=sys.stderr)
    return INTERRUPTED
