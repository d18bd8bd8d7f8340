"""Packages of strangers, installed in a fresh environment, join every command with no line of the core changed.

They are those of docs/write-a-plugin.md as it stands, one of each kind as `contactlab new-plugin` writes it, and those
of tests/outside. All are used in one process: one for each command would take minutes, most of them to import.
"""

from __future__ import annotations

import csv
import json
import re
import shlex
import shutil
from contextlib import chdir
from pathlib import Path
from typing import Any

import pytest
from plugin_page import COMMANDS, FILES
from strangers import Told, fresh_environment, run_all, written

import contactlab
from contactlab.api.part import KINDS
from contactlab.cli import main

OUTSIDE = Path(__file__).parents[1] / "outside"
CHECKS = Path(contactlab.__file__).parent / "data" / "checks"
FRICTION = ["--set", "contacts.0.friction={use=coulomb, mu=0.1}"]
MORE = "mortar-p1, my-dual, gauss-points, gauss-mortar, node-on-segment, closest-point"
OTHERS = ["--set", "integrator=plain-leapfrog"]
FROZEN = ["--set", 'contacts.0.enforcement={use="forward-increment", forces="frozen"}']  # those of the shipped scene
SOME = ["derivatives_are_right", "restart_is_exact", "rotation_turns_the_answers", "hertz", "friction_alone_holds"]
OF_PAGE = {  # commands of the page by how they begin, and what is added: where files go, who else joins, one process
    "contactlab run disc-on-block --with": ["--out", "dual"],
    "contactlab check dual_mortar.py": ["--json", *(word for name in SOME for word in ("--only", name))],
    "contactlab parts": [],
    "contactlab run disc-on-block --set contacts.0.algorithm": ["--out", "three"],
    "contactlab run disc-on-block --set integrator": [*FROZEN, "--out", "leapfrog"],
    "contactlab compare": [*FRICTION, *OTHERS, "--out", "beside", "--jobs", "1"],
    "contactlab matrix": ["--jobs", "1"],
    "contactlab explain": [*FRICTION, *OTHERS],
}
PRESSED = ["pressed.toml", "--set", "contacts.0.algorithm=closest-point"]
SPRINGS = ["--vary", "contacts.0.enforcement=[active-set, soft]", "--jobs", "1", "--out", "springs"]
OWN = {
    "shipped": ["run", "disc-on-block", "--set", "time.end=1e-6", "--out", "shipped"],
    "springs": ["compare", *PRESSED, *SPRINGS],
    "explain": ["explain", *PRESSED, "--set", "contacts.0.enforcement=soft", "--all"],
    "check plain-leapfrog": ["check", "plain-leapfrog", "--json", "--card", "card"],
    "check soft": ["check", "soft", "--json"],
    "check half-traction": ["check", "half-traction", "--json"],
    # its block on an incline alone takes twelve seconds: plain NumPy, a millisecond a step
    "check closest-point": ["check", "closest-point", "--json", *(word for name in SOME for word in ("--only", name))],
}
PYTEST = ["pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib", "--rootdir", "."]


def packages_in(folder: Path) -> list[Path]:
    """The page's, one of each kind, and those of tests/outside."""
    package = {name: text for name, text in FILES.items() if name != "dual_mortar.py"}
    written(folder, {"dual_mortar.py": FILES["dual_mortar.py"]})
    written(folder / "gauss-contact", package | {"src/gauss_contact/__init__.py": ""})
    with chdir(folder):
        for kind in KINDS:
            assert main(["new-plugin", kind, f"own-{kind}", "--with-ci"]) == 0
    shutil.copytree(OUTSIDE, folder / "outside")  # a build leaves folders behind
    shutil.copy(CHECKS / "pressed-in-statics.toml", folder / "pressed.toml")
    return sorted(file.parent for file in folder.rglob("pyproject.toml"))


@pytest.mark.full
def test_strangers_join_every_command(tmp_path: Path) -> None:
    packages = packages_in(tmp_path)
    assert len(packages) == 1 + len(KINDS) + 8
    python = fresh_environment(tmp_path, packages)
    told, of_tests = told_by(python, tmp_path, [path for path in packages if (path / "tests").exists()])
    passed = int(re.findall(r"(\d+) passed", of_tests)[0])
    assert passed > 150
    assert len([*python.parents[1].rglob("own_*/py.typed")]) == len(KINDS)
    listed(told["contactlab parts"])
    assert "disc-on-block: finished" in told["contactlab run disc-on-block --with"]
    three_run_together(summary(tmp_path / "three"))
    steps_as_the_shipped_one(summary(tmp_path / "leapfrog"), summary(tmp_path / "shipped"))
    compares_like_the_shipped_ones(tmp_path / "beside")
    case_is_met(rows_of(tmp_path / "runs" / "matrix" / "matrix.csv"))
    springs_compare_with_multipliers(tmp_path / "springs")
    explained(told["contactlab explain"], told["explain"])
    carded(proved(told["check plain-leapfrog"], "integrator", "plain-leapfrog"), tmp_path / "card")
    proved(told["check soft"], "enforcement", "soft")
    proved(told["check half-traction"], "enforcement", "half-traction")
    for asked, name in (("check closest-point", "closest-point"), ("contactlab check dual_mortar.py", "my-dual")):
        outcomes = {check["name"]: check["outcome"] for check in proved(told[asked], "contact", name)["checks"]}
        assert {outcomes[one] for one in SOME} == {"passed"}


def told_by(python: Path, place: Path, tested: list[Path]) -> tuple[dict[str, str], str]:
    """What commands say by how they begin, and what pytest says of the packages' own tests and of test_outside.py."""
    commands = {
        start: [*shlex.split(line), *OF_PAGE[start]] for start in OF_PAGE for line in COMMANDS if line.startswith(start)
    }
    assert len(commands) == len(OF_PAGE)
    compare = commands["contactlab compare"]
    compare[compare.index("--vary") + 1] = f"contacts.0.algorithm=[{MORE}]"
    commands |= {name: ["contactlab", *words] for name, words in OWN.items()}
    tests = [*(str(path / "tests") for path in tested), str(OUTSIDE / "test_outside.py")]
    answers = run_all(python, place, [*commands.values(), [*PYTEST, *tests]])
    for command, answer in zip([*commands.values(), ["pytest"]], answers, strict=True):
        assert_right(command, answer)
    return dict(zip(commands, (answer.text for answer in answers), strict=False)), answers[-1].text


def assert_right(command: list[str], answer: Told) -> None:
    assert answer.status == 0, f"{shlex.join(command)}\n{answer.text}"
    assert "Traceback" not in answer.text


def summary(folder: Path) -> Any:
    return json.loads((folder / "summary.json").read_text())


def rows_of(table: Path) -> list[dict[str, str]]:
    with table.open() as file:
        return list(csv.DictReader(file))


def listed(told: str) -> None:
    """Parts with their distribution."""
    rows = [line for line in told.splitlines() if "gauss-contact 0.1.0" in line]
    names = ("gauss-points", "rubber", "q1-nodal", "cylinder", "leapfrog")
    assert [next(name for name in names if name in row) for row in rows]
    assert len(rows) == 5
    assert "left out" not in told


def three_run_together(found: Any) -> None:
    for name in ("gauss-points", "rubber", "q1-nodal"):
        assert name in json.dumps(found["parts"])
    assert "gauss-contact" in json.dumps(found["versions"])
    assert found["contacts"]["contacts.0"]["max_pressure"] > 0.0


def steps_as_the_shipped_one(found: Any, shipped: Any) -> None:
    """After a run with contact the reactions of central differences: they are the same primitives."""
    assert found["parts"]["integrator"].startswith("leapfrog")
    assert found["steps"] == shipped["steps"]
    assert found["reactions"] == shipped["reactions"]
    assert found["balance"]["ledger_error"] < 1e-9


def compares_like_the_shipped_ones(folder: Path) -> None:
    """Under friction, with an integrator of others: forces, figures and a page."""
    rows = rows_of(folder / "table.csv")
    assert {row["status"] for row in rows} == {"finished"}
    force = {row["contacts.0.algorithm"]: float(row["reaction"]) for row in rows}
    for name, within in (("my-dual", 0.03), ("gauss-points", 0.01), ("gauss-mortar", 0.01)):
        # other multipliers, or the same by another quadrature, where few nodes of a coarse mesh touch
        assert force[name] == pytest.approx(force["mortar-p1"], rel=within)
        assert force[name] != force["mortar-p1"]
    # the shipped one takes the mean of two normals where a node sits on a vertex
    assert force["closest-point"] == pytest.approx(force["node-on-segment"], rel=0.01)
    assert [*folder.glob("*.svg")]
    report = (folder / "report.html").read_text()
    assert "integration: closest-point (closest-point 0.1.0)" in report
    assert "Times by phase" in report


def case_is_met(rows: list[dict[str, str]]) -> None:
    """Case and algorithm of strangers take part with no other change, and are met at what the case allows."""
    found = {row["contact"]: row["verdict"] for row in rows if row["measure"] == "largest pressure"}
    assert found == {"mortar-p1": "met", "gauss-points": "met"}


def springs_compare_with_multipliers(folder: Path) -> None:
    """Load steps by conditions and enforcement of strangers: springs give way by some per mille of what closed."""
    rows = rows_of(folder / "table.csv")
    assert [row["status"] for row in rows] == ["finished", "finished"]
    exact, soft = (float(row["reaction"]) for row in rows)
    assert 0.99 * exact < soft < exact


def explained(told: str, of_statics: str) -> None:
    """Where parts come from, and how often they are called."""
    assert re.search(r"contacts\.0\.algorithm +my-dual +\S*dual_mortar\.py", told)
    assert re.search(r"contact pieces +1 +step", told)
    assert re.search(r"plain-leapfrog +plain-leapfrog 0\.1\.0", told)
    assert "plain_leapfrog" in told
    for name in ("closest-point", "soft"):
        assert re.search(rf"contacts\.0\.(algorithm|enforcement) +{name} +{name.split('-')[0]}-\w+ 0\.1\.0", of_statics)


def proved(told: str, kind: str, name: str) -> Any:
    """`check` puts the part to unit checks and runs."""
    (part,) = json.loads(told)["parts"]
    assert (part["kind"], part["name"], part["failed"]) == (kind, name, 0)
    outcomes = {check["name"]: check["outcome"] for check in part["checks"]}
    assert outcomes["restart_is_exact"] == outcomes["rotation_turns_the_answers"] == "passed"
    assert set(outcomes.values()) <= {"passed", "not-applicable", "expected"}
    return part


def carded(part: Any, card: Path) -> None:
    """The card says what came out."""
    data = json.loads((card / "card.json").read_text())
    assert data["parts"] == [part]
    assert data["versions"]["contactlab"]
    assert data["versions"]["plain-leapfrog"] == "0.1.0"
    assert {len(digest) for digest in data["sources"].values()} == {32}
    assert "restart is exact | passed" in (card / "card.md").read_text()


def test_packages_of_strangers_see_the_contract_alone() -> None:
    for source in OUTSIDE.glob("*/src/**/*.py"):
        imports = re.findall(r"^(?:from|import) ([\w.]+)", source.read_text(), re.MULTILINE)
        assert {name for name in imports if "contactlab" in name} <= {"contactlab.api", "contactlab.api.plugin"}
