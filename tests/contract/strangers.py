"""An environment as a stranger has it: packages built and installed by pip, and one process that uses them."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import os
import subprocess
import sys
import sysconfig
import tomllib
import venv
from collections.abc import Mapping, Sequence
from contextlib import chdir
from pathlib import Path
from typing import Any, NamedTuple


class Told(NamedTuple):
    """Exit status and output of a command."""

    status: int
    text: str


def written(folder: Path, files: Mapping[str, str]) -> Path:
    """The folder, with the files in it."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def fresh_environment(folder: Path, packages: Sequence[Path]) -> Path:
    """Its Python, with the packages installed; contactlab and what it needs are seen from here, nothing is fetched."""
    here = importlib.util.find_spec("pip") is not None
    venv.create(folder / "env", with_pip=not here)
    python = folder / "env" / "bin" / "python"
    paths = sysconfig.get_paths(vars={"base": str(folder / "env"), "platbase": str(folder / "env")})
    line = f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n"
    Path(paths["purelib"], "installed.pth").write_text(line)
    wheels = _asked(python, folder, "wheels", [str(package) for package in packages])
    pip = [str(python), "-m", "pip"] if not here else [sys.executable, "-m", "pip", "--python", str(python)]
    words = ["install", "--quiet", "--no-deps", "--no-index", "--no-compile", *wheels]
    done = subprocess.run([*pip, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return python


def run_all(python: Path, place: Path, commands: Sequence[Sequence[str]]) -> list[Told]:
    """What commands of contactlab and pytest say, one after another in one process of that environment."""
    return [Told(*answer) for answer in _asked(python, place, "commands", [list(words) for words in commands])]


def _asked(python: Path, place: Path, what: str, request: Any) -> Any:
    """The answer of a process of that environment, which runs the functions below."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "CONTACTLAB_PLUGINS")}
    environment |= {"COLUMNS": "300", "PYTHONDONTWRITEBYTECODE": "1"}
    command = [str(python), "-P", __file__, what]
    done = subprocess.run(
        command, input=json.dumps(request), cwd=place, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])


# --- in that process -----------------------------------------------------------------------------


def _wheels(packages: Sequence[str]) -> list[str]:
    """Wheels by the packages' own build backend, as pip asks it; pip would start two processes for each."""
    from setuptools import build_meta

    found, into = [], Path.cwd()
    for package in packages:
        with chdir(package):
            project = tomllib.loads(Path("pyproject.toml").read_text())
            assert project["build-system"]["build-backend"] == "setuptools.build_meta"
            found.append(str(into / build_meta.build_wheel(str(into))))
    return found


def _commands(commands: Sequence[Sequence[str]]) -> list[Told]:
    import pytest

    from contactlab.cli import main

    answers = []
    for name, *words in commands:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            status = int(pytest.main(words) if name == "pytest" else main(words))
        answers.append(Told(status, said.getvalue()))
    return answers


if __name__ == "__main__":
    print(json.dumps({"wheels": _wheels, "commands": _commands}[sys.argv[1]](json.load(sys.stdin))))
