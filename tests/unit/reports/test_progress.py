"""Progress where there is no terminal: a line for each result, and for what takes its time."""

from __future__ import annotations

import pytest

from contactlab.reports.progress import progress_of


def test_what_is_loaded_in_a_moment_has_no_line(capsys: pytest.CaptureFixture[str]) -> None:
    """Every process told that it loads kernels: 20 lines before the first result."""
    progress = progress_of(2, show=True)
    for _ in range(3):
        for doing in ("preparing kernel 1 of 24", "loading kernel 2 of 24", "compiling kernel 3 of 24", ""):
            progress.say(doing)
    progress.told("one: finished")
    progress.told("two: finished")
    assert capsys.readouterr().err.splitlines() == ["compiling kernel", "1/2 one: finished", "2/2 two: finished"]
