"""Nothing delays the first points of a study: what draws its page is imported while they are computed."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import sys
import contactlab.commands.accuracy
from contactlab.commands.accuracy import import_what_draws
late = {"matplotlib", "bokeh", "scipy.optimize", "scipy.stats", "numba"}
print(sorted(late & set(sys.modules)))
import_what_draws()
print("matplotlib" in sys.modules)
"""


@pytest.mark.full
def test_a_study_begins_without_libraries_that_draw_or_fit() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == ["[]", "True"], done.stderr
