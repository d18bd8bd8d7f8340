"""The matrix from plan to page, with its archive: on the cheapest cases, run as the command runs them."""

from __future__ import annotations

import csv
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from inline import runs_inline

from contactlab.cases.methods import methods
from contactlab.cases.verdict import WORST
from contactlab.cli import main
from contactlab.jobs.archive import FILE, Archive
from contactlab.parts.registry import default_registry
from contactlab.verdicts.files import COLUMNS, MEANINGS, against, verdicts
from contactlab.verdicts.plan import Request, plan
from contactlab.verdicts.run import Matrix

ASKED = ["patch", "pulled-block", "--contact", "mortar-p1", "--contact", "node-on-segment", "--jobs", "1"]

STRANGER = '''
from dataclasses import dataclass
from contactlab.api import Case, Job
from contactlab.api.case import at_most, invariant
from contactlab.api.plugin import Part, hookimpl
from contactlab_mortar.mortar import MortarP1 as Own


@dataclass(frozen=True)
class Steps(Case):
    """A case from outside: a bar that flies a few steps."""
    title = "flight"
    source = "Newton"
    family = "impact"
    integrators = ("central-difference",)
    elements = ("q1",)

    def plan(self, setup, done):
        return [Job("flight", "two-bars", {**setup.changes("left", "right"), "time.end": 0.01})]

    def measures(self, setup):
        return [at_most("steps", 3.0, "three of them fill the time"), invariant("never", 0.0, "it cannot be")]

    def evaluate(self, setup, done):
        return {"steps": done["flight"].summary["steps"], "never": 1.0}


@hookimpl
def contactlab_parts():
    return [Part("case", "flight", "stranger:Steps", "a flight"), Part("contact", "own", "stranger:Own", "own")]
'''


@pytest.fixture(autouse=True, scope="module")
def inline() -> Iterator[None]:
    with runs_inline():
        yield


def run(folder: Path, *words: str) -> int:
    return main(["matrix", *words, "--out", str(folder)])


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("matrix") / "first"
    assert run(folder, *ASKED) == 0
    return folder


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "matrix.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_cell_has_a_verdict(made: Path) -> None:
    found = rows(made)
    assert tuple(found[0]) == COLUMNS
    assert {row["verdict"] for row in found} <= set(WORST)
    cells = verdicts(made)
    assert len(cells) == 4
    by_name = {(key[0], key[2]): verdict for key, verdict in cells.items()}
    assert by_name["patch", "mortar-p1"] == "met"
    assert by_name["patch", "node-on-segment"] == "missed"


def test_the_page_and_json_say_the_same(made: Path) -> None:
    cells = json.loads((made / "matrix.json").read_text())["cells"]
    assert {cell["verdict"] for cell in cells} == set(verdicts(made).values())
    page = (made / "matrix.html").read_text()
    assert "/* data */" not in page
    data = page.split("const data = ")[1].split(";\n")[0]
    assert len(json.loads(data)["cells"]) == len(cells)
    for cell in cells:
        for key in cell["runs"]:
            assert (made / "scenes" / f"{key}.toml").is_file()


def test_the_worst_cells_come_first_and_the_page_explains_verdicts(made: Path) -> None:
    """`patch` is missed with nodes on segments, and `pulled-block`, which comes later in the plan, is not."""
    worst = [WORST.index(cell["verdict"]) for cell in json.loads((made / "matrix.json").read_text())["cells"]]
    assert worst == sorted(worst)
    assert len(set(worst)) > 1
    first = rows(made)[0]
    assert (first["case"], first["contact"]) == ("patch", "node-on-segment")
    assert set(MEANINGS) == set(WORST)


def runs(folder: Path) -> dict[str, tuple[Any, ...]]:
    """Of every run what does not depend on the time."""
    with sqlite3.connect(folder / FILE) as file:
        return {r[0]: r[1:] for r in file.execute("select key, name, scene, status, reason, work from runs")}


def test_nothing_unchanged_is_run_twice(made: Path) -> None:
    with sqlite3.connect(made / FILE) as file:
        before = file.execute("select key, made, cpu_s from runs order by key").fetchall()
    found = verdicts(made)
    assert run(made, *ASKED, "--resume") == 0
    with sqlite3.connect(made / FILE) as file:
        assert file.execute("select key, made, cpu_s from runs order by key").fetchall() == before
    assert verdicts(made) == found


def test_results_are_not_overwritten(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(made, *ASKED) == 2
    assert "--resume" in capsys.readouterr().err


@pytest.mark.full
def test_two_matrices_agree_in_every_verdict(made: Path, tmp_path: Path) -> None:
    assert run(tmp_path / "again", *ASKED, "--against", str(made / "matrix.csv")) == 0
    assert verdicts(tmp_path / "again") == verdicts(made)
    assert runs(tmp_path / "again") == runs(made)


def test_worse_is_told_and_is_the_exit_status(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    better = (made / "matrix.csv").read_text().replace(",silent,", ",met,").replace(",missed,", ",met,")
    (tmp_path / "before.csv").write_text(better)
    assert run(made, *ASKED, "--resume", "--against", str(tmp_path / "before.csv")) == 1
    assert "met, now missed" in capsys.readouterr().out


def test_better_new_and_gone_are_told_apart() -> None:
    assert against(Matrix([]), {("a",): "met"})["gone"] == [(("a",), "met", "")]


@pytest.mark.full
def test_killed_at_any_moment_it_goes_on(made: Path, tmp_path: Path) -> None:
    """Killed as soon as the archive has its first runs, then after the next ones; resumed, all is there."""
    folder = tmp_path / "killed"
    code = "import sys; from contactlab.cli import main; sys.exit(main(sys.argv[1:]))"
    for wanted in (1, 2):
        words = [sys.executable, "-c", code, "matrix", *ASKED, "--out", str(folder), "--resume"]
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        while process.poll() is None and count(folder) < wanted:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    assert run(folder, *ASKED, "--resume") == 0
    assert runs(folder) == runs(made)
    assert verdicts(folder) == verdicts(made)


def count(folder: Path) -> int:
    try:
        with sqlite3.connect(f"file:{folder / FILE}?mode=ro", uri=True) as file:
            return int(file.execute("select count(*) from runs").fetchone()[0])
    except sqlite3.Error:
        return 0


def test_archives_merge(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")  # a narrow terminal cuts the names of machines
    with Archive(tmp_path / FILE):
        pass
    assert main(["archive", "merge", str(tmp_path), str(made)]) == 0
    assert runs(tmp_path) == runs(made)
    assert main(["archive", "merge", str(tmp_path), str(made)]) == 0
    assert "0 runs, 0 cells" in " ".join(capsys.readouterr().out.split())
    with Archive(tmp_path / FILE) as archive:
        for cell in list(archive.cells()):
            archive.add_cell(cell["key"], "another", cell, cell)
    assert main(["archive", "merge", str(made), str(tmp_path)]) == 0
    assert main(["archive", "list", str(made)]) == 0
    listed = capsys.readouterr().out
    assert "another" in listed
    assert "here" in listed
    assert main(["archive", "export", str(made)]) == 0
    assert len(json.loads(capsys.readouterr().out)["cells"]) == 8


def test_a_wrong_name_is_told_with_the_nearest(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(tmp_path / "x", "pach") == 2
    assert "patch" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
    assert main(["archive", "list", str(tmp_path)]) == 2


def test_a_case_from_a_file_takes_part(tmp_path: Path) -> None:
    """A case and an algorithm of one's own appear with no other change; its broken invariant is silent."""
    (tmp_path / "stranger.py").write_text(STRANGER)
    words = ["flight", "--contact", "own", "--contact", "mortar-p1", "--with", str(tmp_path / "stranger.py")]
    assert run(tmp_path / "out", *words, "--jobs", "1") == 0
    found = rows(tmp_path / "out")
    assert {row["contact"] for row in found} == {"own", "mortar-p1"}
    assert {row["measure"]: row["verdict"] for row in found if row["contact"] == "own"}["never"] == "silent"


def test_the_full_matrix_is_large() -> None:
    """At least 1000 cells that apply, with either slave; the quick one has the declared slave alone."""
    registry = default_registry()
    full, quick = (plan(Request(full=choice), registry) for choice in (True, False))
    cells = [cell for cell in full if not cell.case(registry).applies(cell.setup)]
    assert len(cells) >= 1000
    assert {cell.setup.swap for cell in quick} == {False}
    assert len(quick) == len(methods(registry)) * len(registry.names("case"))
    assert {"midplane", "mortar-p1 + nitsche"} <= {cell.choices["contact"] for cell in quick}
    assert len({cell.label for cell in full}) == len(full)
