"""What is in a recording, read back by rerun's own reader and held against `results.vtkhdf`."""

from __future__ import annotations

import re
import resource
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from contactlab.api.drawing.colours import CLOSED, STATES, rgb
from contactlab.errors import ContactlabWarning, RequestError
from contactlab.parts.registry import default_registry
from contactlab.results.results import Results
from contactlab.results.shown_pressure import shown_pressure, shown_shear
from contactlab.run.simulation import simulate

pa = pytest.importorskip("pyarrow", reason="rerun-sdk is not installed (plugin contactlab-rerun)")
chunk = pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed (plugin contactlab-rerun)")

MakeScene = Callable[..., Any]
FILE = "timeline.rrd"
COULOMB = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}
PLASTIC = {f"materials.soft.{key}": value for key, value in {
    "use": "power-law", "strength": 348.0, "prestrain": 0.02, "exponent": 0.03,
}.items()}  # fmt: skip
BOTH = {"record.recorders": ["vtkhdf", {"use": "rerun", "write": "run"}]}
# the viewer keeps single precision, and drawings are scaled: 2^-23 of the largest coordinate, a few times
SINGLE = 1e-6
LANES = "/disc.arc/s_"
DRAWN = 2.0**-11  # positions of meshes, as a share of the model's size: of 12 bits, the last of which is twice that
GRAIN = 2.0**-11  # of curves, as a share of a plot's height
SEEN = 1e-3  # how far a line may be off where steps are left out, as a share of its plot's height


class Rows(NamedTuple):
    """What an entity holds of one component: steps, times [s], and a value per row."""

    steps: np.ndarray
    times: np.ndarray
    values: list[Any]


class Reader:
    """All chunks of a recording by entity path, `/run/energy` and so on."""

    def __init__(self, path: Path) -> None:
        self.moving: dict[str, list[Any]] = {}
        self.static: dict[str, list[Any]] = {}
        with warnings.catch_warnings(action="ignore"):  # it has no index
            reader = chunk.RrdReader(str(path))
        for part in reader.stream():
            kind = self.static if part.is_static else self.moving
            kind.setdefault(part.entity_path, []).append(part.to_record_batch())

    @property
    def paths(self) -> set[str]:
        """Entities without the recording's own properties."""
        return {path for path in self.moving.keys() | self.static.keys() if not path.startswith("/__")}

    def rows(self, path: str, component: str) -> Rows:
        """A component of an entity, in order of the steps."""
        batches = [batch for batch in self.moving[path] if component in batch.schema.names]
        steps = np.concatenate([batch["step"].to_numpy() for batch in batches])
        nanoseconds = np.concatenate([batch["sim_time"].cast(pa.int64()).to_numpy() for batch in batches])
        values = [value for batch in batches for value in batch[component].to_pylist()]
        order = np.argsort(steps, kind="stable")
        return Rows(steps[order], nanoseconds[order] * 1e-9, [values[k] for k in order])

    def scalars(self, path: str) -> tuple[list[str], Rows]:
        """Names of the lines of a plot, and their values at every step."""
        return self.constant(path, "SeriesLines:names"), self.rows(path, "Scalars:scalars")

    def constant(self, path: str, component: str) -> Any:
        """A component that does not change."""
        (batch,) = [batch for batch in self.static[path] if component in batch.schema.names]
        return batch[component].to_pylist()[0]


def packed(colour: str) -> int:
    red, green, blue = rgb(colour)
    return red << 24 | green << 16 | blue << 8 | 0xFF


@pytest.fixture(scope="module")
def run(small_scene: MakeScene, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """A run with friction and plasticity that leaves a recording."""
    return simulate(
        small_scene({**COULOMB, **PLASTIC, **BOTH, "record.contact_work": True, "record.frames": 20, "time.end": 8e-6}),
        tmp_path_factory.mktemp("recorded") / "run",
    )


@pytest.fixture(scope="module")
def reader(run: Results) -> Reader:
    assert run.folder is not None
    return Reader(run.folder / FILE)


# --- one run --------------------------------------------------------------------------------------


def test_tables_have_the_numbers_of_each_node_at_every_frame(run: Results, reader: Reader) -> None:
    rows = reader.rows("/run/numbers/contacts.0", "TextDocument:text")
    assert rows.steps.tolist() == [frame.step for frame in run.frames]
    for frame, value in zip(run.frames, rows.values, strict=True):
        curve = frame.curves["contacts.0"]
        title, _, head, _, *body = value[0].splitlines()
        assert f"step {frame.step}," in title
        names = [name.strip() for name in head.strip("|").split("|")]
        table = [[cell.strip() for cell in line.strip("|").split("|")] for line in body]
        columns = dict(zip(names, zip(*table, strict=True), strict=True))
        assert columns["state"] == tuple(("open", "stick", "slip")[state] for state in curve.state)
        pressure = shown_pressure(curve)
        for name, known in (("s [mm]", curve.s), ("pressure [MPa]", pressure), ("shear [MPa]", shown_shear(curve))):
            shown = np.array(columns[name], float)
            assert shown == pytest.approx(known, rel=1e-4, abs=1e-4 * np.abs(known).max() + 1e-12), name
    # of the last step the record is there, too: the segment under a closed node is that of the record
    record = run.contact["contacts.0"].steps[-1]
    closed = record["state"] > 0
    shown = np.array([int(text) if text else -1 for text in columns["master segment"]])
    assert closed.any()
    assert np.array_equal(shown[closed], record["segment"][closed])


def test_scalars_are_those_of_the_results_file_and_lines_pass_through_all_steps(run: Results, reader: Reader) -> None:
    """Of noise the extremes are there, of a line that is always zero nothing."""
    steps, found = run.steps, set()
    for path, prefix in (
        ("solver/sweeps", ""), ("solver/residual", ""), ("solver/dt", ""), ("energy", "energy."),
        ("contact-work", "energy.contact."), ("reaction", ""), ("time-per-step", "cost."),
        ("nodes/contacts.0", "contacts.0."), ("violation/contacts.0", "contacts.0."),
    ):  # fmt: skip
        names, rows = reader.scalars(f"/run/{path}")
        kept = np.searchsorted(steps["step"], rows.steps)
        assert {0, len(steps["step"]) - 1} <= set(kept.tolist())
        assert len(kept) <= 0.5 * len(steps["step"])
        # durations are whole nanoseconds
        assert np.abs(rows.times - steps["time"][kept]).max() <= 0.5e-9 * (1.0 + 1e-6)
        known = np.array([steps[prefix + name] for name in names])
        assert np.array_equal(np.array(rows.values).T, known[:, kept])
        drawn = np.array([np.interp(steps["step"], rows.steps, line[kept]) for line in known])
        if path == "energy":  # in the others a line swings in every step
            assert np.abs(drawn - known).max() <= SEEN * np.abs(known).max()
        assert (known[:, kept].max(axis=1) >= known.max(axis=1) - SEEN * known.max()).all()
        found |= {prefix + name for name in names}
    assert steps.keys() - found == {"step", "time", "iterations", "contacts.0.changed"}


def test_every_frame_has_its_deformed_mesh(run: Results, reader: Reader) -> None:
    rows = reader.rows("/run/mesh", "Mesh3D:vertex_positions")
    assert rows.steps.tolist() == [frame.step for frame in run.frames]
    assert len(rows.steps) >= 20
    # the camera's image is the plane itself, and it stands as far off as the model is large: nothing is seen askew
    focal = np.ravel(reader.constant("/run/view", "Pinhole:image_from_camera"))[0]
    largest = max(np.abs(run.nodes + frame.displacement).max() for frame in run.frames)
    assert abs(focal - largest) < SINGLE
    for frame, positions in zip(run.frames, rows.values, strict=True):
        shown = np.array(positions)
        assert np.abs(shown[:, :2] - (run.nodes + frame.displacement)).max() < DRAWN * np.ptp(run.nodes)
        assert (shown[:, 2] == -focal).all()
    triangles = np.array(reader.constant("/run/mesh", "Mesh3D:triangle_indices"))
    cells = np.concatenate(list(run.cells.values()))
    assert len(triangles) == 2 * len(cells)
    assert set(triangles.ravel()) == set(cells.ravel())


def test_arrows_are_contact_tractions_in_the_colours_of_the_states(run: Results, reader: Reader) -> None:
    origins = reader.rows("/run/arrows", "Arrows3D:origins").values
    vectors = reader.rows("/run/arrows", "Arrows3D:vectors").values
    colours = reader.rows("/run/arrows", "Arrows3D:colors").values
    focal = np.ravel(reader.constant("/run/view", "Pinhole:image_from_camera"))[0]
    pressures, lengths = [], []
    seen = set()
    for number, frame in enumerate(run.frames):
        curve = frame.curves["contacts.0"]
        closed = np.flatnonzero(curve.state)
        assert len(origins[number] or []) == len(closed)
        if len(closed):
            shown = np.array(origins[number])
            # lines over the mesh are lifted towards the viewer, along the line of sight
            image = focal * shown[:, :2] / -shown[:, 2:]
            assert np.abs(image - np.stack([curve.x, curve.y], axis=1)[closed]).max() < SINGLE
            assert colours[number] == [packed(STATES[state]) for state in curve.state[closed]]
            pressures += np.hypot(curve.pressure, curve.shear)[closed].tolist()
            lengths += np.hypot(*np.array(vectors[number])[:, :2].T).tolist()
            seen |= set(curve.state[closed].tolist())
    assert seen == {1, 2}, "the run shows stick and slip"
    scale = max(lengths) / pressures[int(np.argmax(lengths))]
    assert np.allclose(lengths, scale * np.array(pressures), rtol=1e-5, atol=1e-7)


def test_profiles_are_the_contact_curves(run: Results, reader: Reader) -> None:
    """Values are affine in what is drawn: the scales follow from the axes' own corners."""
    strips = reader.rows("/run/profile/contacts.0/pressure", "LineStrips3D:strips")
    # frames, the first of which is the start, the last steps, and others as far as there is room
    known, shown = [0, *run.steps["step"]], strips.steps.tolist()
    assert {frame.step for frame in run.frames} | set(known[-50:]) <= set(shown) <= set(known)
    peaks = [max(point[1] for point in strip[0]) for strip in strips.values]
    expected = np.array([0.0, *run.contact["contacts.0"].steps["pressure"].max(axis=1)])[np.searchsorted(known, shown)]
    # heights are whole grains: noise of a third of one beside a curve as high as the plot
    assert np.corrcoef(peaks, expected)[0, 1] > 1.0 - GRAIN
    assert max(peaks) <= 1.0 + GRAIN, "the axis reaches the largest pressure of any step"
    labels = reader.constant("/axes/0/labels", "Points3D:labels")
    assert "p [MPa]" in labels
    assert "s along disc.arc [mm]" in labels
    ticks = [float(label) for label in labels if label.replace(".", "").replace("-", "").isdigit()]
    assert max(ticks) <= 1.05 * max(expected)


@pytest.mark.parametrize("kind", ["state", "segment"])
def test_pictures_have_a_column_per_step_and_a_row_per_node(kind: str, run: Results, reader: Reader) -> None:
    """Pixels of a page are told apart as the record's numbers are; the last page ends with the last step."""
    import io

    from PIL import Image

    record = run.contact["contacts.0"].steps
    pages = reader.rows(f"/run/steps/contacts.0/{kind}/picture", "EncodedImage:blob")
    count = len(record["step"])
    assert pages.steps.tolist() == sorted({1, *range(count - 199, 0, -200)})
    last = np.asarray(Image.open(io.BytesIO(bytes(pages.values[-1][0]))))
    nodes = record[kind].shape[1]
    high = last.shape[0] // nodes
    wide = last.shape[1] // 200
    shown = last[high // 2 :: high, wide // 2 :: wide].T[:, np.argsort(np.argsort(run.contact["contacts.0"].last.s))]
    closed, expected = record["state"][-200:] > 0, record[kind][-200:]
    assert ((shown > 0) == closed).all()
    pairs = set(zip(expected[closed].tolist(), shown[closed].tolist(), strict=True))
    assert len({value for value, _ in pairs}) == len(pairs) >= 2
    cursor = reader.rows("/run/steps/contacts.0/all/cursor", "Boxes2D:centers")
    assert cursor.steps.tolist() == record["step"].tolist()


def test_lanes_change_with_the_states(run: Results, reader: Reader) -> None:
    from contactlab.api.frame import STATES as NAMES

    first = run.frames[0].curves["contacts.0"]
    tracks = [path for path in reader.paths if path.startswith(LANES)]
    for path in tracks:
        s = float(re.findall(r"[\d.]+", path.removeprefix(LANES))[0])
        node = int(np.argmin(np.abs(first.s - s)))
        states = [NAMES[frame.curves["contacts.0"].state[node]] for frame in run.frames]
        changes = [k for k in range(len(states)) if k == 0 or states[k] != states[k - 1]]
        rows = reader.rows(path, "StateChange:state")
        assert rows.steps.tolist() == [run.frames[k].step for k in changes]
        assert [value[0] for value in rows.values] == [states[k] for k in changes]


def test_events_count_what_the_curves_show(run: Results, reader: Reader) -> None:
    rows = reader.rows("/run/events", "TextLog:text")
    told: dict[str, int] = {}
    slaves = set(run.layout.contacts[0].slave_nodes.tolist())
    for (text,) in rows.values:
        for part in text.partition(": ")[2].split(", "):
            number, _, what = part.partition(" (node")[0].partition(" ")
            if number.isdigit():
                told[what] = told.get(what, 0) + int(number)
                named = re.findall(r"\d+", part.partition(" (node")[2])
                assert len(named) == (int(number) if int(number) <= 2 else 0)
                assert set(map(int, named)) <= slaves
        if often := re.search(r"node \d+ changes segment (\d+) times", text):
            told["changed segment"] = told.get("changed segment", 0) + int(often[1])
    states = np.array([frame.curves["contacts.0"].state for frame in run.frames])
    old, new = states[:-1], states[1:]
    assert told["closed"] == ((old == 0) & (new > 0)).sum() > 0
    assert told.get("opened", 0) == ((old > 0) & (new == 0)).sum()
    assert told.get("began to slip", 0) == ((old == 1) & (new == 2)).sum()
    assert told.get("began to stick", 0) == ((old == 2) & (new == 1)).sum()
    record = run.contact["contacts.0"].steps
    there = np.isin(record["step"], [frame.step for frame in run.frames])
    segments = record["segment"][there].astype(int)
    both = (states[1:-1] > 0) & (states[2:] > 0)  # the record begins with the first step
    assert told["changed segment"] == (both & (segments[1:] != segments[:-1])).sum() > 0


def test_page_names_parts_versions_and_cost(run: Results, reader: Reader) -> None:
    (text,) = reader.constant("/run/scene", "TextDocument:text")
    for part in (*run.summary["parts"].values(), *run.summary["versions"].values()):
        assert f"| {part} |" in text
    assert f"| steps | {run.summary['steps']} |" in text
    assert run.layout.scene.strip() in text


@pytest.mark.parametrize(("field", "label"), [
    ("equivalent_plastic_strain", "equivalent plastic strain"), ("plastic_strain", "plastic strain"),
    ("pressure", "pressure [MPa]"), ("none", ""),
])  # fmt: skip
def test_other_fields(field: str, label: str, run: Results, tmp_path: Path) -> None:
    read = again(run, tmp_path / "run", field=field)
    if field == "none":
        assert "/run/bar" not in read.paths
    else:
        low, name, high = read.constant("/run/bar/labels", "Points3D:labels")
        assert name == label
        # compression is positive; some of the block is pulled
        assert (float(low) < 0.0) == (field == "pressure")
        assert float(high) > 0.0


def again(run: Results, folder: Path, **options: Any) -> Reader:
    """The same run recorded with other options."""
    from contactlab.run.recorders import record_again

    folder.mkdir()
    record_again(default_registry().make("recorder", {"use": "rerun", **options}), folder, run)
    return Reader(folder / FILE)


def test_recordings_of_the_run_and_of_its_results_are_the_same(run: Results, reader: Reader, tmp_path: Path) -> None:
    """Entities, components, timelines, rows; numbers as far as the results keep them (16 bits of places, 12 of fields).

    `reader` has what was gathered while the run went on.
    """
    later = again(run, tmp_path / "run")
    assert later.paths == reader.paths
    assert moving_components(later) == moving_components(reader)
    for path, component in sorted(moving_components(reader)):
        during, after = reader.rows(path, component), later.rows(path, component)
        assert np.array_equal(during.steps, after.steps), (path, component)
        assert np.array_equal(during.times, after.times), (path, component)
        assert_close(during.values, after.values, f"{path} {component}")
    for path in reader.static.keys() - {"/__properties"}:
        for batch in reader.static[path]:
            for name in batch.schema.names if not path.startswith("/__") else ():
                if ":" in name:
                    assert_close([reader.constant(path, name)], [later.constant(path, name)], f"{path} {name}")


def moving_components(read: Reader) -> set[tuple[str, str]]:
    return {
        (path, name)
        for path, batches in read.moving.items()
        for batch in batches
        for name in batch.schema.names
        if ":" in name
    }


def assert_close(one: Any, other: Any, what: str) -> None:
    """Numbers within what the results keep of them, colours within one of 256, everything else the same."""
    a, b = flat(one), flat(other)
    assert len(a) == len(b), what
    numbers = [(x, y) for x, y in zip(a, b, strict=True) if isinstance(x, float)]
    if "colors" in what:
        parts = np.array([[list(int(value).to_bytes(4)) for value in values] for values in (a, b) if values], int)
        assert parts.size == 0 or np.abs(parts[0] - parts[1]).max() <= 1, what
    elif numbers:
        left, right = np.array(numbers).T
        assert np.abs(left - right).max() <= 2.0**-13 * np.abs(left).max(), what
    else:
        assert a == b, what


def flat(values: Any) -> list[Any]:
    """All that lists and tables hold, one after the other."""
    if isinstance(values, dict):
        return [one for value in values.values() for one in flat(value)]
    return [one for value in values for one in flat(value)] if isinstance(values, list) else [values]


@pytest.mark.full
def test_nothing_of_it_is_done_in_a_run_whose_results_are_stored(small_scene: MakeScene, tmp_path: Path) -> None:
    """With `write = "view"`; where nothing else is stored, the run writes it all the same.

    What the scene asks for is heeded at the look.
    """
    from contactlab.commands.view import recording_in

    asked = {"use": "rerun", "field": "pressure", "write": "view"}
    scene = small_scene({"record.recorders": ["vtkhdf", asked], "time.end": 2e-6})
    simulate(scene, tmp_path / "run")
    assert not (tmp_path / "run" / FILE).exists()
    read = Reader(recording_in(tmp_path / "run", default_registry().make("recorder", "rerun")))
    assert read.constant("/run/bar/labels", "Points3D:labels")[1] == "pressure [MPa]"
    simulate(scene.with_({"record.recorders": [asked]}), tmp_path / "alone")
    assert (tmp_path / "alone" / FILE).is_file()


@pytest.mark.parametrize("beside", [[], ["vtkhdf"]])
def test_field_that_no_body_has_is_refused(small_scene: MakeScene, tmp_path: Path, beside: list[str]) -> None:
    scene = small_scene({"record.recorders": [*beside, {"use": "rerun", "field": "temperature"}]})
    with pytest.raises(RequestError, match="field: got temperature, allowed in this scene: von_mises, pressure, none"):
        simulate(scene, tmp_path / "run")


def test_fewer_frames_keep_the_last_one(run: Results, tmp_path: Path) -> None:
    read = again(run, tmp_path / "run", every=7)
    steps = [frame.step for frame in run.frames]
    expected = sorted({*steps[::7], steps[-1]})
    assert read.rows("/run/mesh", "Mesh3D:vertex_positions").steps.tolist() == expected


def _frame_bytes(run: Results) -> int:
    """Size of a drawn frame: mesh, outlines and inner sides of cells."""
    from contactlab_rerun.drawing import LINE_BYTES, MESH_BYTES
    from contactlab_rerun.mesh_shape import MeshShape

    shape = MeshShape(run.layout)
    return MESH_BYTES * shape.nodes + LINE_BYTES * sum(map(len, [*shape.outlines, *shape.wire]))


def test_meshes_of_large_models_are_drawn_at_fewer_frames(
    run: Results, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is no mesh has all frames; the first and the last frame are always drawn."""
    from contactlab_rerun import drawing, timeline_file

    frames = len(run.frames)
    monkeypatch.setattr(timeline_file, "MESHES", _frame_bytes(run) * frames / 2.5)
    monkeypatch.setattr(drawing, "FEWEST", 4)
    read = again(run, tmp_path / "run")
    steps = [frame.step for frame in run.frames]
    expected = sorted({*steps[::-1][::3], steps[0]})
    for path, component in (("mesh", "Mesh3D:vertex_positions"), ("arrows", "Arrows3D:origins")):
        assert read.rows(f"/run/{path}", component).steps.tolist() == expected
    tracks = [path for path in read.paths if path.startswith(LANES)]
    changes = {step for path in tracks for step in read.rows(path, "StateChange:state").steps.tolist()}
    assert not changes <= set(expected)
    monkeypatch.setattr(drawing, "FEWEST", frames)
    assert again(run, tmp_path / "all").rows("/all/mesh", "Mesh3D:vertex_positions").steps.tolist() == steps


# --- statics --------------------------------------------------------------------------------------


def test_newton_iterations_are_on_the_timeline(small_scene: MakeScene, tmp_path: Path) -> None:
    scene = small_scene({"integrator": "newton", "time.end": 1.0, "supports.1.uy.to": -0.02, **BOTH})
    run = simulate(scene, tmp_path / "run")
    read = Reader(tmp_path / "run" / FILE)
    rows = read.rows("/run/iterations", "TextLog:text")
    assert rows.steps.tolist() == [row.step for row in run.iterations]
    for (text,), row in zip(rows.values, run.iterations, strict=True):
        assert f"iteration {row.number}: force {row.force:.1e}, contact {row.contact:.1e}" in text
        assert f"{row.active} closed" in text
    curves = read.rows("/run/convergence/force", "LineStrips3D:strips")
    assert curves.steps.tolist() == sorted({row.step for row in run.iterations})
    # the residual falls in every step: the last point of a curve is its lowest
    for strips in curves.values:
        heights = [point[1] for point in strips[-1]]
        assert heights[-1] == min(heights)
    _, values = read.scalars("/run/solver/iterations")
    assert np.array_equal(np.ravel(values.values), run.steps["iterations"][values.steps - 1])
    assert_one_iteration_after_the_other(run, read)


def assert_one_iteration_after_the_other(run: Results, read: Reader) -> None:
    """Residuals, active sets and meshes on the timeline of iterations."""
    import io

    from PIL import Image

    def numbers(path: str) -> list[int]:
        return [
            n
            for batch in read.moving[path]
            if "iteration" in batch.schema.names
            for n in batch["iteration"].to_pylist()
        ]

    count = len(run.iterations)
    assert numbers("/run/newton/residuals") == numbers("/run/newton/changes") == list(range(1, count + 1))
    _, residuals = read.scalars("/run/newton/residuals")
    expected = np.log10(np.maximum([(row.force, row.contact) for row in run.iterations], 1e-17))
    assert np.array_equal(np.array(residuals.values), expected)
    (page,) = read.rows("/run/newton/contacts.0/active-set/picture", "EncodedImage:blob").values
    shown = np.asarray(Image.open(io.BytesIO(bytes(page[0]))))
    sets = np.array([row.active_set for row in run.iterations])[:, np.argsort(run.contact["contacts.0"].last.s)]
    high, wide = shown.shape[0] // sets.shape[1], shown.shape[1] // count
    assert np.array_equal(shown[high // 2 :: high, wide // 2 :: wide].T > 0, sets > 0)
    last = {row.step: number for number, row in enumerate(run.iterations, start=1)}
    frames = [last.get(frame.step, 0) for frame in run.frames]
    between = [one.number for one in run.iterates if one.number not in frames]
    assert len(run.iterates) == count
    assert numbers("/run/mesh") == frames + between
    assert numbers("/run/outline") == frames + between
    assert_bodies_move_from_iteration_to_iteration(run, read)


def assert_bodies_move_from_iteration_to_iteration(run: Results, read: Reader) -> None:
    """Meshes are those of the results file, and slave nodes have the colours of their states."""
    size = float(np.ptp(run.nodes, axis=0).max())
    shown = {}
    for batch in read.moving["/run/mesh"]:
        if "iteration" in batch.schema.names and "step" not in batch.schema.names:
            shown |= dict(
                zip(batch["iteration"].to_pylist(), batch["Mesh3D:vertex_positions"].to_pylist(), strict=True)
            )
    assert shown
    for number, points in shown.items():
        expected = run.nodes + run.iterates[number - 1].displacement
        assert np.abs(np.array(points)[:, :2] - expected).max() <= DRAWN * size
    (nodes,) = read.moving["/run/nodes"]
    (contact,) = run.layout.contacts
    assert nodes["iteration"].to_pylist() == [one.number for one in run.iterates]
    for row, points, colours in zip(
        run.iterations, nodes["Points3D:positions"].to_pylist(), nodes["Points3D:colors"].to_pylist(), strict=True
    ):
        is_closed = [colour >> 8 == int(CLOSED[1:], 16) for colour in colours]
        assert is_closed == (row.active_set > 0).tolist()
        assert len(points) == len(contact.slave_nodes)


def test_a_panel_alone(run: Results, tmp_path: Path) -> None:
    """It is named by a part of its name; a name that none has is refused, and leaves nothing."""
    read = again(run, tmp_path / "run", panel="Pressure on")
    assert "/run/mesh" in read.paths
    there = r"allowed: disc-on-block.*; events; nodes of disc.arc; scene"
    with pytest.raises(ValueError, match=f"no panel has nothing in its name; {there}"):
        again(run, tmp_path / "other", panel="nothing")
    assert not list((tmp_path / "other").iterdir())


# --- several runs ---------------------------------------------------------------------------------


@pytest.mark.full
def test_comparison_has_all_runs_on_one_cursor(small_scene: MakeScene, tmp_path: Path) -> None:
    from contactlab.studies.recordings import record_comparison, runs_of, titled_runs

    algorithms = ("mortar-p0", "node-on-segment")
    for number, algorithm in enumerate(algorithms):
        changes = {"contacts.0.algorithm": algorithm, "time.end": 2e-6 + 1e-6 * number}
        simulate(small_scene(changes), tmp_path / "runs" / str(number))
    scene = small_scene(BOTH)
    record_comparison(scene, default_registry(), tmp_path, ["0", "1"])
    read, runs = Reader(tmp_path / FILE), titled_runs(runs_of(tmp_path))
    assert list(runs) == ["mortar-p0, end 2e-06", "node-on-segment, end 3e-06"]
    colours = set()
    for name, run in zip(("mortar-p0-end-2e-06", "node-on-segment-end-3e-06"), runs.values(), strict=True):
        names, rows = read.scalars(f"/{name}/energy")
        assert rows.steps[-1] == run.steps["step"][-1]
        assert np.array_equal(np.array(rows.values)[:, 1], run.steps["energy.internal"][rows.steps - 1])
        assert set(names) == {next(title for title, other in runs.items() if other is run)}
        frames = read.rows(f"/{name}/mesh", "Mesh3D:vertex_positions")
        assert len(frames.steps) == len(run.frames)
        (outline,) = read.constant(f"/{name}/outline", "LineStrips3D:colors")
        (line,) = read.constant(f"/{name}/profile/contacts.0/pressure", "LineStrips3D:colors")
        assert outline == line
        colours.add(outline)
        # frictionless contact neither sticks nor slips
        assert {c for frame in read.rows(f"/{name}/arrows", "Arrows3D:colors").values for c in frame or ()} == {
            packed(CLOSED)
        }
        assert any(text.endswith(f" [{name}]") for (text,) in read.rows(f"/{name}/events", "TextLog:text").values)
    assert len(colours) == 2


# --- runs that end early --------------------------------------------------------------------------


def test_failed_run_says_so_at_its_end(small_scene: MakeScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("contactlab.run.contact_guard.TOO_DEEP", 1e-4)  # surfaces may hardly lie in each other
    run = simulate(small_scene(BOTH), tmp_path / "run")
    assert run.status == "diverged"
    read = Reader(tmp_path / "run" / FILE)
    texts = [text for (text,) in read.rows("/run/events", "TextLog:text").values]
    assert texts[-1] == f"{run.summary['steps']}: diverged: {run.reason}"
    (page,) = read.constant("/run/scene", "TextDocument:text")
    assert f"(diverged at step {run.summary['steps']})" in page.splitlines()[0]
    levels = [level for (level,) in read.rows("/run/events", "TextLog:level").values]
    assert levels[-1] == "ERROR"


def test_warnings_stand_on_the_page_and_among_the_events(small_scene: MakeScene, tmp_path: Path) -> None:
    run = simulate(small_scene({"materials.soft.yield_stress": 1.0, "time.end": 2e-6, **BOTH}), tmp_path / "run")
    (warning,) = (warning for warning in run.warnings if warning.code == "plasticity")
    read = Reader(tmp_path / "run" / FILE)
    (page,) = read.constant("/run/scene", "TextDocument:text")
    assert f"| plasticity | {warning.text} |" in page
    events = [text for (text,) in read.rows("/run/events", "TextLog:text").values]
    assert any(": body " in text and "von Mises" in text for text in events)


def test_full_disk_is_said_and_leaves_nothing_half(run: Results, tmp_path: Path) -> None:
    """The library would wait for ever: it never hears of it."""
    from contactlab.run.recorders import record_again, record_stored

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    rerun = default_registry().make("recorder", "rerun")
    try:
        with pytest.raises(OSError, match="File too large"):
            record_again(rerun, tmp_path, run)
        with pytest.warns(ContactlabWarning, match="rerun cannot write to .*: file too large; .* are complete"):
            record_stored({"rerun": rerun}, tmp_path, run)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.full
def test_recording_of_a_resumed_run_is_whole(small_scene: MakeScene, tmp_path: Path) -> None:
    """It begins anew with all that was stored before the run was stopped."""
    import signal

    from contactlab.run.interruption import Interrupted

    def stop(fraction: float, step: int, time: float, error: float) -> None:
        if fraction > 0.4:
            signal.raise_signal(signal.SIGINT)

    scene = small_scene({**COULOMB, **BOTH})
    with pytest.raises(Interrupted):
        simulate(scene, tmp_path / "run", progress=stop)
    texts = [text for (text,) in Reader(tmp_path / "run" / FILE).rows("/run/events", "TextLog:text").values]
    assert ": interrupted: stopped by SIGINT" in texts[-1]
    run = simulate(scene, tmp_path / "run", resume=True)
    read = Reader(tmp_path / "run" / FILE)
    _, rows = read.scalars("/run/energy")
    assert rows.steps[[0, -1]].tolist() == run.steps["step"][[0, -1]].tolist()
    assert len(read.rows("/run/mesh", "Mesh3D:vertex_positions").steps) == len(run.frames)
    assert not any("interrupted" in text for (text,) in read.rows("/run/events", "TextLog:text").values)
