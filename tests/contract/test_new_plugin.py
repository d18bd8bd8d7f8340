"""`contactlab new-plugin` writes a package of each kind that builds, installs and passes its own tests."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
from contextlib import chdir
from pathlib import Path

import pytest
from setuptools import build_meta

from contactlab.api.part import KINDS
from contactlab.cli import main
from contactlab.commands.new_plugin import plugin_files
from contactlab.errors import RequestError

OUTSIDE = Path(__file__).parents[1] / "outside"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a package of each kind, as the command writes it."""
    folder = tmp_path_factory.mktemp("strangers")
    with chdir(folder):
        for kind in KINDS:
            assert main(["new-plugin", kind, f"own-{kind}", "--with-ci"]) == 0
    return folder


def wheel_of(folder: Path, into: Path) -> Path:
    """The wheel that the package's own build backend makes of it, as pip would ask it to."""
    with chdir(folder):
        project = tomllib.loads(Path("pyproject.toml").read_text())
        assert project["build-system"]["build-backend"] == "setuptools.build_meta"
        return into / build_meta.build_wheel(str(into))


@pytest.fixture(scope="module")
def installed(made: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All of them and those of tests/outside, installed by pip; one process builds the wheels, or it takes a minute."""
    into, wheels = tmp_path_factory.mktemp("site"), tmp_path_factory.mktemp("wheels")
    copies = tmp_path_factory.mktemp("outside") / "packages"
    shutil.copytree(OUTSIDE, copies)  # a build leaves folders behind
    packages = [file.parent for place in (made, copies) for file in sorted(place.glob("*/pyproject.toml"))]
    built = [wheel_of(folder, wheels) for folder in packages]
    words = ["install", "--quiet", "--no-deps", "--no-index", "--no-compile", "--target", str(into)]
    pip = [sys.executable, "-m", "pip", *words, *map(str, built)]
    done = subprocess.run(pip, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return into


def test_their_tests_pass_where_they_are_installed(made: Path, installed: Path) -> None:
    """Every kind: the checks of contactlab.testing, and a run with a known answer, in one process of its own."""
    shown = run_tests(installed, made, *(folder / "tests" for folder in sorted(made.iterdir())))
    assert int(re.findall(r"(\d+) passed", shown)[0]) > 60
    assert len([*installed.glob("own_*/py.typed")]) == len(KINDS)


def test_packages_of_strangers_take_part(installed: Path, tmp_path: Path) -> None:
    """Contact algorithm, integrator and enforcement of tests/outside, which import contactlab.api alone."""
    for source in OUTSIDE.glob("*/src/**/*.py"):
        imports = re.findall(r"^(?:from|import) ([\w.]+)", source.read_text(), re.MULTILINE)
        assert {name for name in imports if "contactlab" in name} <= {"contactlab.api", "contactlab.api.plugin"}
    run_tests(installed, tmp_path, OUTSIDE / "test_outside.py")


def run_tests(installed: Path, place: Path, *tests: Path) -> str:
    """Output of tests in a process of its own that sees what was installed; they must pass."""
    outside = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "CONTACTLAB_PLUGINS")}
    outside |= {"PYTHONPATH": str(installed), "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "200"}
    words = ["-q", "-p", "no:cacheprovider", "--import-mode=importlib", "--durations=8", "--rootdir", str(place)]
    pytest_ = [sys.executable, "-m", "pytest", *words, *map(str, tests)]
    done = subprocess.run(pytest_, cwd=place, env=outside, capture_output=True, text=True, check=False)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("kind", KINDS)
def test_a_package_has_what_a_release_needs(kind: str) -> None:
    files = plugin_files(kind, f"own-{kind}", with_ci=True)
    module = f"own_{kind}"
    assert set(files) == {
        "pyproject.toml", "README.md", "LICENSE", "CITATION.cff", ".github/workflows/checks.yml",
        f"src/{module}/__init__.py", f"src/{module}/plugin.py", f"src/{module}/{kind}.py", f"src/{module}/py.typed",
        f"tests/test_{module}.py",
    }  # fmt: skip
    assert not [name for name, text in files.items() if re.search(r"\$\w", text)]
    project = tomllib.loads(files["pyproject.toml"])
    assert project["project"]["entry-points"]["contactlab"] == {f"own-{kind}": f"{module}.plugin"}
    assert "## Cite" in files["README.md"]
    assert f"contactlab check own-{kind} --kind {kind}" in files[".github/workflows/checks.yml"]
    assert not [name for name in plugin_files(kind, f"own-{kind}") if "workflows" in name]


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_is_short_and_plain(kind: str) -> None:
    """NumPy, the standard library and the contract are all it imports; a class with a page's length of code."""
    source = plugin_files(kind, f"own-{kind}")[f"src/own_{kind}/{kind}.py"]
    tree = ast.parse(source)
    imports = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    imports |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    foreign = {name for name in imports if name.split(".")[0] not in {*sys.stdlib_module_names, "numpy"}}
    assert foreign <= {"contactlab.api", "contactlab.api.case", "contactlab.api.meshing"}
    assert 15 <= len([line for line in source.splitlines() if line.strip()]) <= 80


@pytest.mark.parametrize(
    ("kind", "name", "word"),
    [
        ("contacts", "my-contact", 'did you mean "contact"'),
        ("contact", "MyContact", "lower-case words"),
        ("contact", "json", "word of Python"),
        ("contact", "class", "word of Python"),
        ("contact", "contact-algorithm", "as one of contactlab.api"),
    ],
)
def test_what_cannot_be_a_package_is_refused(kind: str, name: str, word: str) -> None:
    with pytest.raises(RequestError, match=word):
        plugin_files(kind, name)


@pytest.mark.parametrize(("name", "word"), [("mortar-p1", "of this name, from"), ("numpy", "would hide it")])
def test_names_that_are_taken_are_refused(
    name: str, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new-plugin", "contact", name]) == 2
    assert word in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]


def test_an_existing_folder_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own-mesh").mkdir()
    assert main(["new-plugin", "mesh", "own-mesh"]) == 2
    assert "the folder is there already" in capsys.readouterr().err
    assert not [*(tmp_path / "own-mesh").iterdir()]
