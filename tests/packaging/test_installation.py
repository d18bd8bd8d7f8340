"""What `make demo` installs holds all of our packages as they are declared, and it finds out if a part of it fails."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
import zipfile
from configparser import ConfigParser
from pathlib import Path

import pytest

from contactlab import __version__

ROOT = Path(__file__).parents[2]
PROJECTS = [ROOT, *sorted(file.parent for file in ROOT.glob("plugins/*/pyproject.toml"))]


@pytest.mark.full
def test_every_package_becomes_an_editable_wheel_with_its_entry_points_and_needs(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, str(ROOT / "tools" / "editables.py"), str(tmp_path)], capture_output=True, check=True
    )
    wheels = {file.name.partition("-")[0]: file for file in tmp_path.iterdir()}
    assert len(wheels) == len(PROJECTS)
    for project in PROJECTS:
        declared = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        name = declared["name"].replace("-", "_")
        with zipfile.ZipFile(wheels[name]) as wheel:
            texts = {Path(entry).name: wheel.read(entry).decode() for entry in wheel.namelist()}
        assert texts[f"__editable__.{name}-{__version__}.pth"].strip() == str(project / "src")
        points = ConfigParser(delimiters="=")
        points.optionxform = str  # type: ignore[method-assign, assignment]  # names keep their case
        points.read_string(texts["entry_points.txt"])
        groups = dict(declared.get("entry-points", {}))
        if "scripts" in declared:
            groups["console_scripts"] = declared["scripts"]
        assert {group: dict(points[group]) for group in points.sections()} == groups
        needs = [line for line in texts["METADATA"].splitlines() if line.startswith("Requires-Dist")]
        assert len([line for line in needs if "extra ==" not in line]) == len(declared["dependencies"])


@pytest.mark.parametrize("broken", ["setuptools", "tools/editables.py", "constraints.txt", "--force-reinstall", "none"])
def test_an_installation_of_which_a_step_fails_is_not_taken_for_whole(tmp_path: Path, broken: str) -> None:
    """The mark that all is there appears where every step has worked, and only there."""
    if shutil.which("make") is None:
        pytest.skip("no make")
    marker = tmp_path / "venv" / "runnable"
    python = tmp_path / "venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    # Python and pip as far as make sees them: they fail where they are given the word that stands for a step
    python.write_text(f'#!/bin/sh\ncase " $* " in *" {broken} "*) exit 1;; esac\nexit 0\n', encoding="utf-8")
    python.chmod(0o755)
    done = subprocess.run(
        ["make", "-s", f"VENV={marker.parent}", f"PYTHON={sys.executable}", str(marker)],
        cwd=ROOT, env=os.environ | {"MAKEFLAGS": ""}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode == 0) == marker.exists() == (broken == "none"), done.stderr
