"""What scenes, results and tables show of themselves, and what other libraries get of them."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from matplotlib.figure import Figure
from tiers import some

import contactlab
from contactlab.cases.verdict import WORST
from contactlab.errors import ContactlabError, RequestError
from contactlab.explanation.explain import explain
from contactlab.parts.registry import default_registry
from contactlab.reports.notebook.bar import notebook_bar
from contactlab.reports.notebook.fields import moment_of, values_of
from contactlab.reports.notebook.libraries import library
from contactlab.results.precision import PLACES, SHOWN
from contactlab.results.results import Results
from contactlab.scene.scene import bundled_scenes, load_scene
from contactlab.studies.table import Table
from contactlab.verdicts.cell import CellResult
from contactlab.verdicts.plan import Request, plan
from contactlab.verdicts.run import Matrix

ROOT = Path(__file__).parents[3]
LINES = 20


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    changes = {
        "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "supports.1.uy.to": -0.02,
        "time.end": 2e-6, "record.frames": 3, "record.recorders": ["vtkhdf"],
    }  # fmt: skip
    scene = load_scene("disc-on-block").with_(changes)
    told: list[float] = []
    found = contactlab.simulate(
        scene, out=tmp_path_factory.mktemp("notebook") / "run", progress=lambda fraction, *_: told.append(fraction)
    )
    assert told[-1] == 1.0
    return found


@pytest.mark.parametrize("name", list(bundled_scenes()))
def test_a_scene_in_few_lines(name: str) -> None:
    text = repr(load_scene(name))
    assert len(text.splitlines()) <= LINES
    assert name in text
    assert len(text) < 2000


def test_an_explanation_in_few_lines() -> None:
    """All of its tables are pages of numbers: kernels, arrays and modules are named only."""
    scene = load_scene("block-on-incline")
    text = repr(explain(scene, scene.registry))
    assert len(text.splitlines()) <= LINES
    assert len(text) < 2000
    assert "friction" in text
    assert "kernels" in text


class TestScene:
    def test_rigid_surfaces_beyond_the_bodies_are_in_the_picture(self) -> None:
        """A roll below is seen all around; of a long floor as much as the bodies are wide."""
        scene = load_scene("disc-on-block")
        surfaces = {
            "roll": {"arc": {"centre": [0.0, -1.0], "radius": 0.4, "angles": [-180.0, 180.0]}},
            "floor": {"line": [[900.0, -1.5], [-900.0, -1.5]]},
        }
        sides = [{"slave": "block.bottom", "master": name, "algorithm": "mortar-p1"} for name in surfaces]
        free = [support for support in scene.data["supports"] if support["on"] != "block.bottom"]
        axes = scene.with_(rigid=surfaces, contacts=sides, supports=free).plot().axes[0]
        low, high = axes.get_ylim()
        assert low < -1.5
        assert high > 0.6
        assert axes.get_xlim()[1] < 900.0

    def test_it_shows_meshes_and_toml(self) -> None:
        scene = load_scene("block-on-incline")
        html = scene._repr_html_()
        assert "data:image/png" in html
        assert "mortar-p0" in html
        assert "[[contacts]]" in html


class TestResults:
    def test_few_lines_with_what_is_looked_at_first(self, results: Results) -> None:
        text = repr(results)
        assert len(text.splitlines()) <= LINES
        for word in ("disc-on-block: finished", "pressure up to", "frames stored", "reaction of disc.top"):
            assert word in text
        assert len(repr(results.contact)) < 300

    def test_html_has_pictures_and_warnings(self, results: Results) -> None:
        warning = {"code": "made-up", "value": 2.0, "limit": 1.0, "key": "level", "text": "<b>too coarse</b>"}
        warned = Results(**{**vars(results), "summary": {**results.summary, "warnings": [warning]}})
        html = warned._repr_html_()
        assert html.count("data:image/png") == 2
        assert "made-up" in html
        assert "&lt;b&gt;too coarse" in html

    def test_a_run_that_left_nothing_says_so(self, results: Results) -> None:
        nothing = Results(**{**vars(results), "frames": (), "stress": {}})
        assert "no picture: the run stored no fields" in nothing._repr_html_()

    def test_fields_by_their_definition(self, results: Results) -> None:
        """Pressure is minus the mean of the normal stresses; displacements of a cell are those of its corners."""
        moment = moment_of(results)
        stress = moment.cells["disc"]["stress"]
        assert values_of(results, moment, "pressure")["disc"] == pytest.approx(-stress[:, :3].mean(axis=1))
        corners = results.displacement[results.cells["disc"]]
        stored = 2.0**-PLACES * np.abs(results.displacement).max()  # as exactly as displacements are stored
        assert values_of(results, moment, "displacement_y")["disc"] == pytest.approx(
            corners[:, :, 1].mean(axis=1), abs=stored
        )

    def test_the_end_is_the_same_with_and_without_files(self, results: Results) -> None:
        without = Results(**{**vars(results), "frames": ()})
        assert "fields of the end alone" in repr(without)
        assert "frames stored" not in repr(without)
        for name in ("von_mises", "stress_yy"):
            a, b = (values_of(r, moment_of(r), name)["block"] for r in (results, without))
            largest = max(np.abs(cells["stress"]).max() for cells in moment_of(without).cells.values())
            assert a == pytest.approx(b, abs=2.0**-SHOWN * largest), "as exactly as fields are stored"

    @pytest.mark.parametrize(("field", "frame"), [("von mises", -1), ("von_mises", 7)])
    def test_what_is_not_there_is_named(self, results: Results, field: str, frame: int) -> None:
        with pytest.raises(RequestError, match="there is no such"):
            results.plot(field, frame)

    def test_figures_and_films(self, results: Results) -> None:
        assert isinstance(results.plot("stress_yy", frame=0), Figure)
        curve = results.contact["contacts.0"].last
        (axes,) = curve.plot("mm N s t").axes
        assert "MPa" in axes.get_ylabel()
        film = results.animate("displacement", stride=2)
        film._draw_was_started = True
        film._draw_frame(1)
        (axes, _) = film._fig.axes
        drawn = len(axes.collections), len(axes.lines), len(axes.texts)
        assert all(drawn), "bodies, marks of supports, and the arrow of the one that moves"
        *_, last = film.new_frame_seq()
        film._draw_frame(last)
        assert (len(axes.collections), len(axes.lines), len(axes.texts)) == drawn, "nothing of a frame before is left"
        assert axes.get_title("left") == f"disc-on-block, t = {results.history['time'][-1]:.4g} s", "the end is shown"
        assert not axes.get_title("center"), "one title, whoever draws"

    def test_everything_is_drawn_into_the_axes_of_the_caller(self, results: Results) -> None:
        curve = results.contact["contacts.0"].last
        draw = (
            results.plot, results.plot_force, results.plot_pressure, curve.plot,
            load_scene("disc-on-block").plot,
        )  # fmt: skip
        figure = Figure()
        places = figure.subplots(2, 3).ravel()
        for method, axes in zip(draw, places, strict=False):
            assert method(ax=axes) is figure
            assert axes.has_data()
        film = results.animate(ax=places[-1])
        film._draw_was_started = True
        assert film._fig is figure

    def test_the_curve_of_a_support(self, results: Results) -> None:
        """The disc goes down by 0.02: force and displacement along the motion are positive."""
        (axes,) = results.plot_force("disc.top").axes
        x, y = axes.lines[0].get_data()
        assert x == pytest.approx(-results.history["disc.top.uy"])
        assert y == pytest.approx(-results.history["disc.top.fy"])
        assert axes.get_xlabel() == "displacement of disc.top along -y [mm]"
        assert axes.get_ylabel() == "force of disc.top along -y [N/mm]"
        (other,) = results.plot_force("block.bottom", component="magnitude").axes
        assert other.lines[0].get_ydata() == pytest.approx(
            np.hypot(results.history["block.bottom.fx"], results.history["block.bottom.fy"])
        )
        with pytest.raises(RequestError, match=r'did you mean "disc\.top"'):
            results.plot_force("disc.tp")

    def test_a_wrong_name_gets_the_nearest_one(self, results: Results) -> None:
        with pytest.raises(KeyError, match=r'did you mean "contacts\.0"'):
            results.contact["contact.0"]
        with pytest.raises(KeyError, match=r'did you mean "disc\.top\.fy"'):
            results.history["disc.top.fz"]
        with pytest.raises(KeyError, match=r'did you mean "energy\.kinetic"'):
            results.steps["energy.kinetc"]
        without = Results(**{**vars(results), "step_source": (), "frames": (), "folder": None})
        with pytest.raises(KeyError, match="they are kept in files"):
            without.steps["energy.kinetic"]
        with pytest.raises(IndexError, match=r"no frame -1: frames are kept in files: simulate\(scene, out="):
            without.frames[-1]
        with pytest.raises(IndexError, match=f"no frame {len(results.frames)}: there are {len(results.frames)}, 0 to"):
            results.frames[len(results.frames)]

    def test_forces_of_round_off_are_zero_in_the_text(self, results: Results) -> None:
        (x, y) = results.summary["reactions"]["disc.top"]
        assert 0.0 < abs(x) < 1e-7 * abs(y)
        assert "reaction of disc.top      [0, -" in repr(results)

    def test_a_contact_answers_to_the_name_that_tables_have(self, results: Results) -> None:
        assert results.contact["disc.arc on block.top"] is results.contact["contacts.0"]
        assert list(results.contact) == ["contacts.0"]

    @pytest.mark.full
    def test_units_go_along(self, results: Results) -> None:
        units = results.to_frame().attrs["units"]
        assert (units["disc.top.fy"], units["disc.top.uy"], units["energy.kinetic"]) == ("N/mm", "mm", "mJ/mm")
        data = results.to_xarray()
        assert data["contacts.0.pressure"].attrs["units"] == "MPa"
        assert data["disc.stress_xx"].attrs["units"] == "MPa"
        assert data["displacement"].attrs["units"] == "mm"

    def test_frames_of_pandas(self, results: Results) -> None:
        history = results.to_frame()
        assert history.index.name == "time"
        assert history["disc.top.fy"].to_numpy() == pytest.approx(results.history["disc.top.fy"])
        curve = results.contact["contacts.0"].last
        assert list(curve.to_frame().columns) == list(curve.COLUMNS)

    def test_a_data_set_of_xarray(self, results: Results) -> None:
        data = results.to_xarray()
        assert data.attrs["status"] == "finished"
        largest = abs(results.displacement).max()  # what frames are rounded by follows from it
        assert data["displacement"].sel(component="y").isel(time=-1).to_numpy() == pytest.approx(
            results.displacement[:, 1], abs=2.0**-PLACES * largest
        )
        pressure = data["contacts.0.pressure"]
        assert pressure.dims == ("time", "contacts.0_node")
        assert float(pressure[-1].max()) == results.contact["contacts.0"].last.pressure.max()

    @pytest.mark.full
    def test_a_mesh_of_pyvista(self, results: Results) -> None:
        """Area and fields are those of the run."""
        mesh = results.mesh(0)
        assert mesh.n_cells == sum(map(len, results.cells.values()))
        areas = mesh.compute_cell_sizes(length=False, volume=False)["Area"]
        assert areas[mesh.cell_data["body"] == 1].sum() == pytest.approx(1.8 * 0.3, rel=1e-6)  # the block, undeformed
        assert results.mesh()["von_mises"] == pytest.approx(
            np.concatenate(list(values_of(results, moment_of(results), "von_mises").values()))
        )

    def test_a_mesh_has_contact_fields_and_principal_stresses(self, results: Results) -> None:
        mesh, curve = results.mesh(), results.contact["contacts.0"].last
        (contact,) = results.layout.contacts
        pressure = mesh.point_data["contact_pressure"]
        assert pressure[contact.slave_nodes] == pytest.approx(curve.pressure)
        assert np.isnan(np.delete(pressure, contact.slave_nodes)).all()
        assert mesh.point_data["contact_state"][contact.slave_nodes] == pytest.approx(curve.state)
        stress = np.asarray(mesh.cell_data["stress"])
        full = np.zeros((len(stress), 3, 3))
        full[:, 0, 0], full[:, 1, 1], full[:, 2, 2], full[:, 0, 1] = stress.T
        full[:, 1, 0] = full[:, 0, 1]
        exact = np.linalg.eigvalsh(full)[:, ::-1]
        for k in range(3):
            assert mesh.cell_data[f"principal_{k + 1}"] == pytest.approx(exact[:, k], abs=1e-9 * np.abs(exact).max())


class TestTable:
    def test_few_lines(self, table: Table) -> None:
        text = repr(table)
        assert len(text.splitlines()) == len(table) + 2
        assert "killed" in repr(table.failed)

    def test_html_has_every_run_and_every_reason(self, table: Table) -> None:
        html = table._repr_html_()
        assert html.count("<tbody") == len(table)
        assert "reactions differ by &lt;3 %&gt; &amp; more" in html
        assert "data:image/png" in html

    def test_figures_and_frames(self, table: Table) -> None:
        assert isinstance(table.plot_cost(), Figure)
        assert table.plot_cost()._repr_png_().startswith(b"\x89PNG")
        assert isinstance(table.plot_pressures(), Figure)
        assert list(table.to_frame()["pressure_error"]) == pytest.approx(table["pressure_error"], nan_ok=True)


def test_a_matrix_shows_itself() -> None:
    cells = plan(Request(["two-bars"], full=True), default_registry())
    verdicts = [str(WORST[k % len(WORST)]) for k in range(len(cells))]
    matrix = Matrix([(c, CellResult(v, "finished", "because <1>")) for c, v in zip(cells, verdicts, strict=True)])
    assert len(repr(matrix).splitlines()) <= LINES
    assert "because &lt;1&gt;" in matrix._repr_html_()
    assert len(matrix.to_frame()) == len(cells)


def test_a_missing_library_is_named_with_the_extra() -> None:
    with pytest.raises(RequestError, match=r"contactlab\[notebook\]"):
        library("no_such_library", "mesh")


def test_a_bar_in_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []

    class Handle:
        def update(self, html: str) -> None:
            drawn.append(html)

    def display(html: str, display_id: bool) -> Handle:
        drawn.append(html)
        return Handle()

    fake = ModuleType("IPython.display")
    fake.HTML, fake.display = str, display  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython.display", fake)
    show = notebook_bar("a <scene>")
    show(0.5, 10, 0.1, 1e-9)  # too soon after the first picture
    show(1.0, 20, 0.2, 1e-9)
    assert len(drawn) == 2
    assert "a &lt;scene&gt;" in drawn[0]
    assert 'value="1.0000"' in drawn[1]


def test_a_timeline_that_nobody_can_show(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("contactlab.reports.notebook.grid.default_registry", lambda: contactlab_without_viewers())
    with pytest.raises(ContactlabError, match="no installed recorder"):
        results.view()


def contactlab_without_viewers() -> object:
    from contactlab.parts.registry import Registry

    return Registry(entry_points=[])


NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.full
@pytest.mark.parametrize("name", some([path.stem for path in NOTEBOOKS], ["first-look"]))
def test_notebooks_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every cell runs in a fresh folder, and what it shows can be shown; stored outputs would grow old."""
    specification = importlib.util.spec_from_file_location("notebooks", ROOT / "tools" / "site" / "notebooks.py")
    assert specification is not None
    assert specification.loader is not None
    tool = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(tool)
    monkeypatch.chdir(tmp_path)
    (path,) = (path for path in NOTEBOOKS if path.stem == name)
    shown = [tool.as_html(cell.shown) for cell in tool.run_notebook(path)]
    assert sum(map(bool, shown)) >= 3


def test_notebooks_are_notebooks() -> None:
    import nbformat

    assert len(NOTEBOOKS) >= 3
    for path in NOTEBOOKS:
        nbformat.validate(nbformat.read(path, as_version=4))
        assert '"outputs": []' in path.read_text()
        assert "data:image" not in path.read_text()
