"""docs/write-a-plugin.md works as it stands: its files are built, installed in a fresh environment and run."""

from __future__ import annotations

import csv
import importlib
import importlib.util
import io
import json
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tokenize
import venv
from dataclasses import dataclass
from pathlib import Path

import pytest

from contactlab.api import Setup
from contactlab.cases.run_case import evaluated, run_case
from contactlab.cases.verdict import judge

PAGE = (Path(__file__).parents[2] / "docs" / "write-a-plugin.md").read_text()
FILES = dict(re.findall(r"^File `([^`]+)`:\n\n```\w+\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))
COMMANDS = [
    line for block in re.findall(r"^```sh\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL) for line in block.splitlines()
]
PACKAGE = "gauss-contact"


@dataclass(frozen=True)
class Place:
    """A folder with the page's files, and an environment of its own in which the package is installed."""

    folder: Path
    python: Path

    def run(self, *words: str, status: int = 0) -> str:
        """Output of a command of the page, whose exit status must be `status`."""
        program = {"contactlab": ["-c", "from contactlab.cli import main; raise SystemExit(main())"]}
        command = [str(self.python), *program.get(words[0], ["-m", words[0]]), *words[1:]]
        environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "CONTACTLAB_PLUGINS")}
        environment |= {"COLUMNS": "300", "PYTHONDONTWRITEBYTECODE": "1"}
        done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        assert "Traceback" not in done.stderr
        return done.stdout + done.stderr

    def of_page(self, start: str) -> str:
        """Run the one command of the page that starts like this."""
        (line,) = (line for line in COMMANDS if line.startswith(start))
        return self.run(*shlex.split(line))


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Place:
    """Nothing is fetched: the new environment sees the packages of this one."""
    folder = tmp_path_factory.mktemp("stranger")
    for name, text in FILES.items():
        file = folder / ("" if name == "my_friction.py" else PACKAGE) / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    (folder / PACKAGE / "src" / "gauss_contact" / "__init__.py").touch()
    here = importlib.util.find_spec("pip") is not None
    venv.create(folder / "env", with_pip=not here)
    python = folder / "env" / "bin" / "python"
    paths = sysconfig.get_paths(vars={"base": str(folder / "env"), "platbase": str(folder / "env")})
    line = f"import site; site.addsitedir({sysconfig.get_path('purelib')!r})\n"
    Path(paths["purelib"], "installed.pth").write_text(line)
    pip = [str(python), "-m", "pip"] if not here else [sys.executable, "-m", "pip", "--python", str(python)]
    words = ["install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index", f"./{PACKAGE}"]
    done = subprocess.run([*pip, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return Place(folder, python)


def test_the_page_has_its_files() -> None:
    assert {name.rpartition("/")[2] for name in FILES} == {
        "my_friction.py", "pyproject.toml", "plugin.py", "contact.py", "material.py", "element.py", "cylinder.py",
        "integrator.py", "test_parts.py",
    }  # fmt: skip


def test_the_algorithm_is_short_and_plain() -> None:
    """Under 60 lines without blank ones, comments and docstrings; NumPy and the contract are all it imports."""
    source = FILES["src/gauss_contact/contact.py"]
    skipped = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    lines, fresh = set(), True
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        docstring = token.type == tokenize.STRING and fresh
        if token.type not in skipped and not docstring:
            lines |= set(range(token.start[0], token.end[0] + 1))
        fresh = token.type in skipped
    assert 30 < len(lines) < 60
    assert set(re.findall(r"^(?:from|import) ([\w.]+)", source, re.MULTILINE)) == {
        "dataclasses", "typing", "numpy", "contactlab.api",
    }  # fmt: skip


def test_the_case_is_short_and_right(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Under 40 lines, and met by a mortar at the error it allows; an outside case needs nothing but the contract."""
    source = FILES["src/gauss_contact/cylinder.py"]
    assert len([line for line in source.splitlines() if line.strip()]) < 40
    assert set(re.findall(r"^(?:from|import) ([\w.]+)", source, re.MULTILINE)) == {
        "dataclasses", "numpy", "contactlab.api", "contactlab.api.case",
    }  # fmt: skip
    (tmp_path / "page_cylinder.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    case, setup = (
        importlib.import_module("page_cylinder").Cylinder(),
        Setup("mortar-p1", element="q1", integrator="newton"),
    )
    _, done = run_case(case, setup)
    finding = judge(case, setup, done, evaluated(case, setup, done))
    assert finding.verdict == "met", finding.reason


def test_parts_are_listed_with_their_distribution(place: Place) -> None:
    (listed,) = [place.of_page("contactlab parts --with")]
    rows = [line for line in listed.splitlines() if "gauss-contact 0.1.0" in line]
    names = ("gauss-mortar", "rubber", "q1-nodal", "cylinder", "plain-leapfrog")
    assert [next(name for name in names if name in row) for row in rows]
    assert len(rows) == 5
    assert any("slip-limit" in line and "my_friction" in line for line in listed.splitlines())
    assert "left out" not in listed


def test_all_three_run_together(place: Place) -> None:
    assert "disc-on-block: finished" in place.of_page("contactlab run disc-on-block --set contacts.0.algorithm")
    summary = json.loads((place.folder / "runs" / "disc-on-block-001" / "summary.json").read_text())
    parts = json.dumps(summary["parts"])
    for name in ("gauss-mortar", "rubber", "q1-nodal"):
        assert name in parts
    assert "gauss-contact" in json.dumps(summary["versions"])
    assert summary["contacts"]["contacts.0"]["max_pressure"] > 0.0


def test_the_integrator_is_short_and_runs(place: Place) -> None:
    """Forty lines in its class, and after a run with contact the reactions of the shipped one to round-off."""
    source = FILES["src/gauss_contact/integrator.py"]
    lines = [line for line in source[source.index("    def bind") :].splitlines() if line.strip()]
    assert len(lines) <= 40
    assert "disc-on-block: finished" in place.of_page("contactlab run disc-on-block --set integrator=plain-leapfrog")
    place.run(*shlex.split("contactlab run disc-on-block --set time.end=1e-6 --out shipped"))
    own = max((place.folder / "runs").glob("disc-on-block-*"), key=lambda folder: folder.stat().st_mtime)
    found, expected = (json.loads((folder / "summary.json").read_text()) for folder in (own, place.folder / "shipped"))
    assert found["parts"]["integrator"].startswith("plain-leapfrog")
    assert found["steps"] == expected["steps"]
    for name, force in expected["reactions"].items():
        # sums in another order, some hundred steps long
        assert found["reactions"][name] == pytest.approx(force, rel=1e-9, abs=1e-9 * abs(force[1]))
    assert found["balance"]["ledger_error"] < 1e-9


def test_it_compares_like_the_shipped_mortar(place: Place) -> None:
    """Same multipliers, other quadrature: forces within 1 % where a few nodes of a coarse mesh touch."""
    place.of_page("contactlab compare")
    with next((place.folder / "runs").glob("disc-on-block*/table.csv")).open() as file:
        rows = {row["contacts.0.algorithm"]: row for row in csv.DictReader(file)}
    assert {row["status"] for row in rows.values()} == {"finished"}
    force = {name: float(row["reaction"]) for name, row in rows.items()}
    assert force["gauss-mortar"] == pytest.approx(force["mortar-p1"], rel=0.01)
    assert force["gauss-mortar"] != force["mortar-p1"]


def test_case_and_algorithm_appear_in_the_matrix(place: Place) -> None:
    """An installed package of strangers takes part with no other change, and is met at what its case allows."""
    place.of_page("contactlab matrix")
    with (place.folder / "runs" / "matrix" / "matrix.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["measure"] == "largest pressure"]
    assert {row["contact"]: row["verdict"] for row in rows} == {"mortar-p1": "met", "gauss-mortar": "met"}


def test_it_is_explained(place: Place) -> None:
    shown = place.of_page("contactlab explain")
    assert "gauss-mortar" in shown
    assert "gauss-contact" in shown
    assert re.search(r"contacts\.0\.algorithm +gauss-mortar +gauss-contact 0\.1\.0", shown)
    assert re.search(r"contact pieces +1 +step", shown)


def test_its_own_tests_pass(place: Place) -> None:
    (line,) = (line for line in COMMANDS if line.startswith("pytest"))
    shown = place.run(*shlex.split(line), "-q", "-p", "no:cacheprovider")
    assert re.search(r"\d\d passed", shown)
    assert "failed" not in shown


def test_one_file_serves_run_compare_and_explain(place: Place) -> None:
    shown = place.of_page("contactlab run disc-on-block --with my_friction.py")
    assert "disc-on-block: finished" in shown
    extra = ["--with", "my_friction.py", "--set", "contacts.0.friction=slip-limit", "--set", "time.end=1e-6"]
    assert "slip-limit" in place.run("contactlab", "explain", "disc-on-block", *extra)
    out = ["--out", "with-file", "--vary", "contacts.0.friction.mu=[0.0, 0.3]"]
    place.run("contactlab", "compare", "disc-on-block", *extra, *out)
    with (place.folder / "with-file" / "table.csv").open() as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["finished", "finished"]
