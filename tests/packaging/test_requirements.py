"""What `make demo` installs beside our own packages is all that these need, and it finds out if that fails."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import requires
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ["contactlab", *sorted(path.name for path in (ROOT / "plugins").iterdir() if path.is_dir())]


def test_all_that_the_installed_packages_ask_for_is_listed_and_nothing_of_ours() -> None:
    done = subprocess.run(
        [sys.executable, str(ROOT / "tools" / "requirements.py")], capture_output=True, text=True, check=True
    )
    listed = done.stdout.split("\n")[:-1]
    # as built, from the same files: an extra has a marker, and so has nothing else
    asked = {line for package in PACKAGES for line in requires(package) or () if "extra ==" not in line}
    names = [re.match(r"[\w.-]+", line) for line in listed]
    assert {_plain(line) for line in listed} == {
        _plain(line)
        for line in asked
        if re.match(r"[\w.-]+", line)[0] not in PACKAGES  # type: ignore[index]
    }
    assert len({name[0] for name in names if name}) == len(listed), "each once"


def _plain(line: str) -> tuple[str, frozenset[str]]:
    """A requirement, whatever the order of its bounds."""
    name = re.match(r"[\w.-]+", line)
    assert name
    return name[0], frozenset(line[name.end() :].replace(" ", "").split(","))


@pytest.mark.parametrize("broken", ["--no-deps", "-r", "none"])
def test_an_installation_of_which_a_half_fails_is_not_taken_for_whole(tmp_path: Path, broken: str) -> None:
    """The two halves run side by side: the mark that all is there appears where both have worked, and only there."""
    if shutil.which("make") is None:
        pytest.skip("no make")
    marker = tmp_path / "venv" / "runnable"
    python = tmp_path / "venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    # pip as far as make sees it: fails where it is given the word that stands for a half
    python.write_text(f'#!/bin/sh\ncase " $* " in *" {broken} "*) exit 1;; esac\nexit 0\n', encoding="utf-8")
    python.chmod(0o755)
    done = subprocess.run(
        ["make", "-s", f"VENV={marker.parent}", f"PYTHON={sys.executable}", str(marker)],
        cwd=ROOT, env=os.environ | {"MAKEFLAGS": ""}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode == 0) == marker.exists() == (broken == "none"), done.stderr
