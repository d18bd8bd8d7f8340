"""A comparison read back is the one that was made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from inline import runs_inline

import contactlab
from contactlab.errors import RequestError
from contactlab.reports.sheet import escaped
from contactlab.studies.table import Row, Table

SMALL = {
    "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "supports.1.uy.to": -0.02, "level": 1,
    "integrator": "newton", "integrator.steps": 4, "time.history": True, "record.frames": 4,
    "record.recorders": ["vtkhdf"],
}  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Table:
    vary = {"contacts.0.algorithm": ["mortar-p0", "node-on-segment"], "contacts.0.swap": [False, True],
            "materials.soft.young": [7000.0]}  # fmt: skip
    scene = contactlab.load_scene("disc-on-block").with_(SMALL)
    with runs_inline(), pytest.MonkeyPatch.context() as patch:
        patch.setattr("contactlab.reports.page.draw", lambda table: {})  # table.tex is looked at, no figure
        return contactlab.compare(scene, vary, out=tmp_path_factory.mktemp("table") / "out", jobs=1, progress=False)


def same(a: Row, b: Row) -> None:
    for name, value in a.record().items():
        assert b.record()[name] == pytest.approx(value, nan_ok=True), name
    assert (a.varied, a.choices, a.parts, a.warnings, list(a.notes)) == (
        b.varied, b.choices, b.parts, b.warnings, b.notes,
    )  # fmt: skip
    assert a.curve == b.curve
    for name, shape in a.shapes.items():
        assert b.shapes[name].corners == pytest.approx(shape.corners)
    for name, column in a.history.items():
        assert b.history[name] == pytest.approx(column, nan_ok=True)


@pytest.mark.full
def test_rows_curves_and_reference(made: Table) -> None:
    assert made.folder is not None
    read = contactlab.load_table(made.folder)
    assert read.columns() == made.columns()
    for a, b in zip(made.rows, read.rows, strict=True):
        same(a, b)
    assert read.study.vary.keys() == made.study.vary.keys()
    assert read.scene == made.scene
    assert made.reference is None or np.array_equal(read.reference.profile.value, made.reference.profile.value)
    assert repr(read) == repr(made)


def test_what_is_drawn_is_the_same(made: Table) -> None:
    assert made.folder is not None
    read = contactlab.load_table(made.folder)
    for table in (made, read):
        (axes,) = table.plot_force("disc.top").axes
        lines = [line for line in axes.lines if len(line.get_xdata()) > 1]
        assert len(lines) == 4
        assert len({(line.get_color(), line.get_linestyle()) for line in lines}) == 4
        assert lines[0].get_ydata() == pytest.approx(-made.rows[0].history["disc.top.fy"])
    figure = read.plot_pressures()
    assert len(figure.axes) == 4
    assert read.plot_pressures(ax=figure.axes[0]) is figure


def test_latex(made: Table) -> None:
    assert made.folder is not None
    text = (made.folder / "table.tex").read_text()
    assert text == made.to_latex()
    body = [line for line in text.splitlines() if line.endswith(r"\\")]
    assert len(body) == 2 + len(made)
    assert len({line.count("&") for line in body}) == 1
    assert "peak force" in body[0]
    assert escaped(r"a_b & 5 %\{x}") == r"a\_b \& 5 \%\textbackslash{}\{x\}"


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="no comparison"):
        contactlab.load_table(tmp_path)
    (tmp_path / "table.json").write_text("{}")
    with pytest.raises(RequestError, match="cannot be read"):
        contactlab.load_table(tmp_path)
