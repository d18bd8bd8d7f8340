"""References of one's own: a CSV file, and runs on finer meshes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from inline import runs_inline

from contactlab.comparison import compare
from contactlab.errors import RequestError
from contactlab.jobs.driver import Driver
from contactlab.jobs.run import here
from contactlab.parts.registry import default_registry
from contactlab.results.results import ContactCurve
from contactlab.scene.scene import load_scene
from contactlab.studies.finest import FINEST, answer_key, finest_plan, steadiest, with_multipliers
from contactlab.studies.reference import load_reference
from contactlab.studies.study import Study
from contactlab.studies.table import Row, Table

X = np.linspace(-1.0, 1.0, 101)


@pytest.fixture(autouse=True, scope="module")
def inline() -> Iterator[None]:
    with runs_inline():
        yield


def csv_file(path: Path, heads: str, *columns: np.ndarray) -> str:
    rows = [",".join(f"{value:.9g}" for value in row) for row in np.stack(columns, axis=1)]
    path.write_text("\n".join([heads, *rows]))
    return str(path)


def test_a_curve_alone_is_taken_as_exact_and_with_a_spread_as_known_to_it(tmp_path: Path) -> None:
    pressure = 1.0 - X**2
    exact = load_reference(csv_file(tmp_path / "mine.csv", "x_mm,p_MPa", X, pressure))
    assert (exact.name, exact.pressure_uncertainty) == ("mine", 0.0)
    assert exact.mismatch({"anything": 1}) == ""
    rough = load_reference(csv_file(tmp_path / "r.csv", "x,pressure,spread", X, pressure, 0.02 * pressure))
    assert rough.pressure_uncertainty == pytest.approx(0.02)


@pytest.mark.parametrize("heads", ["a,b", "x,q"])
def test_a_file_without_the_columns_is_refused(tmp_path: Path, heads: str) -> None:
    with pytest.raises(RequestError, match="columns x and p"):
        load_reference(csv_file(tmp_path / "mine.csv", heads, X, X))


def test_what_an_answer_depends_on_tells_scenes_apart() -> None:
    scene = load_scene("disc-on-block")
    same = scene.with_({"level": 3, "contacts.0.algorithm": "mortar-p1", "contacts.0.swap": True})
    assert answer_key(same.data) == answer_key(scene.data)
    other = scene.with_({"supports.1.uy": {"ramp": "parabola", "to": -0.05}})
    assert answer_key(other.data) != answer_key(scene.data)


def test_the_two_algorithms_that_change_least_make_it(curve_of: object) -> None:
    def row(algorithm: str, level: int, factor: float, status: str = "finished") -> Row:
        zero, p = np.zeros_like(X), factor * (1.0 - X**2)
        curve = ContactCurve(X, X, zero, p, zero, p, zero, np.zeros(101, np.int32), np.zeros(101, np.int32))
        return Row("", algorithm, "a", level, {}, status, "", curve=curve)

    changes = {"a": 0.05, "b": 0.01, "c": 0.02}
    rows = [row(name, level, 1.0 + change * (level == 1)) for name, change in changes.items() for level in (1, 2)]
    rows += [row("d", 1, 1.0), row("d", 2, 1.0, "diverged")]
    kept = steadiest(Table(rows, Study(scene="s"), None, {}), (1, 2))
    assert [(r.algorithm, r.level) for r in kept] == [("b", 1), ("b", 2), ("c", 1), ("c", 2)]


def test_a_scene_without_a_reference_is_measured_against_finer_meshes(tmp_path: Path) -> None:
    scene = load_scene("disc-on-block").with_(
        {"integrator": "newton", "supports.1.uy": {"ramp": "linear", "to": -0.06}, "record.recorders": [],
         "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2]}
    )  # fmt: skip
    with Driver(jobs=1) as driver:
        found = driver.result(finest_plan([scene], 0, tmp_path))
    reference = found.at(scene.data)
    # bilinear cells, contact on a dozen segments, a root at its edges: between half and twenty per cent
    assert 5e-3 < reference.pressure_uncertainty < 0.2
    assert reference.scalar("reaction") > 0.0
    again = here(finest_plan([scene], 0, tmp_path), lambda run: pytest.fail("a run was repeated"))
    assert list(tmp_path.glob(f"{FINEST}/*/{FINEST}.json"))
    assert again.at(scene.data).profile.value == pytest.approx(reference.profile.value)  # read, not made
    assert "no finer run" in found.mismatch(scene.with_({"bodies.disc.shift": [0.1, 0.0]}).data)


def test_compare_takes_a_reference(tmp_path: Path) -> None:
    file = csv_file(tmp_path / "mine.csv", "x,p", X, np.maximum(0.0, 1.0 - (X / 0.2) ** 2))
    table = compare(
        load_scene("disc-on-block").with_({"integrator": "newton", "record.recorders": []}),
        {"contacts.0.algorithm": ("mortar-p0",)}, jobs=1, progress=False, reference=file,
    )  # fmt: skip
    (row,) = table.rows
    assert row.reference == "mine"
    assert not math.isnan(row["pressure_error"])


def test_methods_with_an_error_of_their_own_make_no_reference() -> None:
    """Penalties and barriers move surfaces, nodes on segments fail the patch test: no errors of the mesh."""
    names = with_multipliers(default_registry())
    assert {"mortar-p0", "mortar-p1", "mortar-dual"} <= set(names)
    assert not {"node-on-segment", "gauss-point", "midplane", "barrier"} & set(names)
