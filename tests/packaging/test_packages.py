"""Packages as they are published: built, looked into, installed alone in a fresh environment, and run there."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from email import message_from_string
from email.message import Message
from pathlib import Path

import pytest

import contactlab

ROOT = Path(__file__).parents[2]
PROJECTS = [ROOT, *sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))]
OPTIONAL = {"contactlab-ipc"}  # by an extra of the core: its library has no wheels for some machines
NAMES = {path: "contactlab" if path == ROOT else path.name for path in PROJECTS}
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.egg-info", "build", "dist")

pytestmark = pytest.mark.full  # a minute; CI builds packages in a job of its own

FULL = os.environ.get("CONTACTLAB_PACKAGES") == "full"
"""Whether kernels are compiled from the wheels, too, as `make packages` does: a minute of processor time."""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with wheel and sdist of every project; what is built from is a copy of what the repository holds."""
    folder = tmp_path_factory.mktemp("packages")
    running = []
    for project in PROJECTS:
        copy = folder / "sources" / NAMES[project]
        shutil.copytree(project / "src", copy / "src", ignore=LEFT_OUT)
        for file in project.iterdir():
            if file.is_file():
                shutil.copy(file, copy)
        if project == ROOT:
            shutil.copytree(ROOT / "docs", copy / "docs", ignore=lambda path, names: {n for n in names if "." not in n})
        build = ["sdist", "--dist-dir", str(folder), "bdist_wheel", "--dist-dir", str(folder)]
        words = [sys.executable, "-c", "from setuptools import setup; setup()", *build]
        if len(running) >= 2:
            _finish(running.pop(0))
        running.append(subprocess.Popen(words, cwd=copy, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True))
    for process in running:
        _finish(process)
    return folder


def _finish(process: subprocess.Popen[str]) -> None:
    said, _ = process.communicate()
    assert process.returncode == 0, said


def wheel(built: Path, project: Path) -> zipfile.ZipFile:
    (path,) = built.glob(f"{NAMES[project].replace('-', '_')}-{contactlab.__version__}-*.whl")
    return zipfile.ZipFile(path)


def metadata(archive: zipfile.ZipFile) -> Message:
    (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
    return message_from_string(archive.read(name).decode())


@pytest.mark.parametrize("project", PROJECTS, ids=NAMES.get)
class TestContents:
    def test_a_wheel_has_every_source_and_nothing_else(self, built: Path, project: Path) -> None:
        """Data and the marker of types, too; neither tests nor anything that was only lying there."""
        held = {name for name in wheel(built, project).namelist() if ".dist-info/" not in name}
        package = project / "src" / NAMES[project].replace("-", "_")
        written = {
            path.relative_to(project / "src").as_posix()
            for path in package.rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        assert held == written
        assert f"{package.name}/py.typed" in held

    def test_metadata(self, built: Path, project: Path) -> None:
        """What an index shows: licence with its text, authors, a description, the Pythons that numba has wheels for."""
        archive = wheel(built, project)
        facts = metadata(archive)
        assert facts["Version"] == contactlab.__version__
        assert facts["License-Expression"] == "BSD-3-Clause"
        assert facts["Author"] == "contactlab developers"
        assert facts["Description-Content-Type"] == "text/markdown"
        assert "](docs/" not in facts.get_payload(), "an index shows the page without its neighbours"
        pythons = {word.rpartition(" ")[2] for word in facts.get_all("Classifier", []) if "Python :: 3." in word}
        assert pythons == {"3.11", "3.12", "3.13", "3.14"}
        assert any(name.endswith("/licenses/LICENSE") for name in archive.namelist())
        assert any(name.endswith("entry_points.txt") for name in archive.namelist())

    def test_a_source_distribution_can_be_built_from(self, built: Path, project: Path) -> None:
        name = f"{NAMES[project].replace('-', '_')}-{contactlab.__version__}"
        with tarfile.open(built / f"{name}.tar.gz") as archive:
            held = set(archive.getnames())
        assert {f"{name}/pyproject.toml", f"{name}/LICENSE", f"{name}/PKG-INFO"} <= held
        assert not [path for path in held if "__pycache__" in path or "/runs/" in path]


def test_versions_agree() -> None:
    """That of the core is written once; plugins, which are released with it, carry the same."""
    for project in PROJECTS:
        settings = tomllib.loads((project / "pyproject.toml").read_text())["project"]
        assert settings.get("version", contactlab.__version__) == contactlab.__version__, "run tools/release.py"
    assert f"\nversion: {contactlab.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    newest = re.search(
        r"(?m)^## (\S+) \((not released|\d{4}-\d\d-\d\d)\)$", (ROOT / "docs" / "CHANGELOG.md").read_text()
    )
    assert newest is not None
    assert newest[1] == contactlab.__version__ or newest[2] == "not released"


def test_one_name_brings_every_usual_plugin(built: Path) -> None:
    required = {re.split("[<>=]", line)[0] for line in metadata(wheel(built, ROOT)).get_all("Requires-Dist", [])}
    assert {NAMES[project] for project in PROJECTS if project != ROOT} <= required


def test_an_index_would_take_them(built: Path) -> None:
    if importlib.util.find_spec("twine") is None:
        pytest.skip("twine is not installed: pip install '.[publish]'")
    words = [
        sys.executable,
        "-m",
        "twine",
        "check",
        "--strict",
        *map(str, built.glob("*.whl")),
        *map(str, built.glob("*.gz")),
    ]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def alone(built: Path) -> Path:
    """The program of an environment into which `contactlab` was installed by its name, from these wheels.

    Nothing is fetched: other libraries are those of this environment, without anything of this repository.
    """
    libraries, env = built / "libraries", built / "env"
    libraries.mkdir()
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if "contactlab" not in path.name and path.suffix not in (".pth", ".egg-link"):
            (libraries / path.name).symlink_to(path)
    here = importlib.util.find_spec("pip") is not None
    venv.create(env, with_pip=not here)
    paths = sysconfig.get_paths(vars={"base": str(env), "platbase": str(env)})
    Path(paths["purelib"], "libraries.pth").write_text(f"{libraries}\n")
    python = env / "bin" / "python"
    pip = [str(python), "-m", "pip"] if not here else [sys.executable, "-m", "pip", "--python", str(python)]
    words = ["install", "--quiet", "--no-index", "--find-links", str(built), "contactlab"]
    done = subprocess.run([*pip, *words], cwd=built, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return env / "bin" / "contactlab"


def run(alone: Path, folder: Path, *words: str, **variables: str) -> str:
    """What the program prints in a folder of its own."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [alone, *words], cwd=folder, env={**environment, **variables}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_one_name_brings_parts_that_can_be_imported(alone: Path, tmp_path: Path) -> None:
    listed = json.loads(run(alone, tmp_path, "parts", "--json"))
    assert not listed["broken"]
    assert {part["distribution"] for part in listed["parts"]} == set(NAMES.values()) - OPTIONAL
    where = "import contactlab, contactlab_mortar; print(contactlab.__file__, contactlab_mortar.__file__)"
    found = subprocess.run([alone.with_name("python"), "-c", where], capture_output=True, text=True, check=True).stdout
    assert all(str(alone.parents[1]) in path for path in found.split())


@pytest.mark.full
@pytest.mark.parametrize("contact", [False, pytest.param(True, marks=pytest.mark.skipif(not FULL, reason="slow"))])
def test_the_one_name_runs_a_scene(alone: Path, tmp_path: Path, contact: bool) -> None:
    """What it needs is compiled there: little without contact; the rest of a run and what it writes is the same."""
    if contact:
        scene: tuple[str, ...] = (
            "disc-on-block",
            "time.end=3e-8",
            "bodies.disc.mesh.cells=[4, 1]",
            "bodies.block.mesh.cells=[6, 1]",
        )
    else:
        scene = ("two-bars", "time.end=0.01", "contacts=[]")
    words = [word for text in (*scene[1:], "record.frames=1") for word in ("--set", text)]
    variables = {"CONTACTLAB_CACHE": str(tmp_path / "cache"), "NUMBA_OPT": "0"}
    run(alone, tmp_path, "run", scene[0], *words, "--out", "out", **variables)
    left = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"scene.toml", "summary.json", "history.csv", "results.vtkhdf", "timeline.rrd"} <= left
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["status"] == "finished"
