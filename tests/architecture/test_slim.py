"""`slim.txt` is what contactlab needs without the viewer, and what is then missing is said."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

SLIM = Path(__file__).parents[2] / "slim.txt"


def needed(name: str, without: str) -> set[str]:
    """Distributions that `name` needs on this machine, directly or not, where `without` is left out."""
    found: set[str] = set()
    to_visit = [name]
    while to_visit:
        at = to_visit.pop()
        if at in found or at == without:
            continue
        found.add(at)
        every = map(Requirement, requires(at) or ())
        to_visit += [canonicalize_name(r.name) for r in every if r.marker is None or r.marker.evaluate({"extra": ""})]
    return found


def test_the_slim_list_is_everything_but_the_viewer() -> None:
    lines = [line for line in SLIM.read_text().splitlines() if line and not line.startswith("#")]
    assert lines == sorted(needed("contactlab", "contactlab-rerun"))


@pytest.fixture
def slim_environment() -> dict[str, str]:
    usual = "core,cases,dynamics,effects,friction,mortar,quads,segments,solids,statics"
    return {**os.environ, "CONTACTLAB_PLUGINS": usual}


@pytest.mark.full
def test_without_the_viewer_a_run_has_no_timeline_and_says_so_once(
    slim_environment: dict[str, str], tmp_path: Path
) -> None:
    folder = str(tmp_path / "run")
    program = [sys.executable, "-P", "-m", "contactlab"]
    done = subprocess.run(
        [*program, "run", "two-bars", "--out", folder], env=slim_environment, capture_output=True, text=True, check=True
    )
    assert (done.stdout + done.stderr).count("no timeline") == 1
    assert "pip install contactlab-rerun" in done.stdout
    assert not (tmp_path / "run/timeline.rrd").exists()
    view = subprocess.run([*program, "view", folder], env=slim_environment, capture_output=True, text=True, check=False)
    assert view.returncode == 2
    assert "pip install contactlab-rerun" in view.stderr
