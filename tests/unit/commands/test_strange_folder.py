"""Nothing in the folder that a command is called in is run as code, whatever its name.

Every module of the standard library, of the project and of what it uses stands there as a file that tells of itself.
"""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from tiers import some

import contactlab
from contactlab.commands.arguments import COMMANDS

RUN = ["vertex-to-vertex", "--set", "time.end=1e-7", "--set", "record.recorders=[]"]
TRIED: dict[str, tuple[int, list[str]]] = {
    "run": (0, [*RUN, "--out", "run"]),
    "compare": (0, [*RUN, "--vary", "level=[1]", "--out", "compared", "--jobs", "1", "--scheduler", "dask"]),
    "choose": (2, ["two-bars", "--set", "contacts=[]"]),  # its processes are those of error-budget
    "error-budget": (0, [*RUN, "--time-limit", "60", "--jobs", "1", "--out", "budget"]),
    "matrix": (0, ["two-bars", "--contact", "mortar-p0", "--jobs", "1", "--out", "matrix"]),
    "archive": (0, ["list", "compared"]),
    "view": (2, ["compared"]),
    "plot": (0, ["compared", "force"]),
    "runs": (0, []),
    "cite": (2, ["nowhere"]),
    "explain": (0, ["two-bars"]),
    "scenes": (0, []),
    "new-scene": (0, ["mine", "--from", "two-bars"]),
    "new-plugin": (0, ["friction", "my-friction"]),
    "parts": (0, []),
    "check": (0, ["coulomb", "--only", "numbers_in_range"]),
    "doctor": (0, []),
    "completion": (0, ["bash"]),
}
"""By command: its exit status, and words that let it start all kinds of processes that it has."""


@pytest.fixture(scope="module")
def strange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of files that write HIT when they are run."""
    folder = tmp_path_factory.mktemp("strange")
    text = f"open({str(folder / 'HIT')!r}, 'a').write(__name__ + ' '); raise SystemExit('a file of the folder was run')"
    for name in {*sys.stdlib_module_names, *packages_distributions()}:
        (folder / f"{name}.py").write_text(text)
    return folder


@pytest.mark.full
@pytest.mark.parametrize("command", some(TRIED, ["check"]))
def test_no_file_of_the_folder_is_run(command: str, strange: Path) -> None:
    program = strange.parent / "program.py"  # what pip installs: Python looks in its folder, not in the working one
    program.write_text("import sys\nfrom contactlab.cli import main\nif __name__ == '__main__': sys.exit(main())\n")
    status, words = TRIED[command]
    done = subprocess.run(
        [sys.executable, str(program), command, *words], cwd=strange, capture_output=True, text=True, check=False
    )
    hit = strange / "HIT"
    ran = hit.read_text() if hit.exists() else ""
    hit.unlink(missing_ok=True)
    assert ran == "", done.stderr
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr


def test_every_command_is_tried() -> None:
    assert TRIED.keys() == COMMANDS.keys()


def test_every_process_is_started_without_the_working_folder() -> None:
    """Python itself, started by name, gets -P or -I: brothers of the commands that are tried above."""
    root = Path(contactlab.__file__).parents[2]
    started = [
        (file, line)
        for file in [*root.glob("src/**/*.py"), *root.glob("plugins/*/src/**/*.py")]
        for line in file.read_text().splitlines()
        if "[sys.executable" in line
    ]
    assert len(started) >= 4
    assert [(file, line) for file, line in started if '"-P"' not in line and '"-I"' not in line] == []
