"""A run that is kept is the same run only while the files that its scene names hold the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from contactlab.api import Job
from contactlab.jobs.keys import row_key, run_key
from contactlab.scene.scene import Scene, load_scene

SCENE = """
integrator = {{ use = "newton" }}
materials.soft = {{ use = "linear-elastic", young = 1.0, poisson = 0.0, density = 1.0 }}
bodies.block = {{ material = "soft", element = "q1", mesh = {mesh} }}
supports = [{{ on = "block.{foot}", ux = 0.0, uy = 0.0 }}]
loads = [{load}]
"""
PLAIN = '{ use = "rectangle", x = [0.0, 1.0], y = [0.0, 1.0], cells = [1, 1] }'
FROM_FILE = '{ use = "file", path = "block.vtk" }'
LOADS = {
    "in time": '{ on = "block.top", pressure = { ramp = "table", to = 1.0, file = "table.csv" } }',
    "along an edge": '{ on = "block.top", pressure = 1.0, profile = { by = "x", file = "table.csv" } }',
}
VTK = """# vtk DataFile Version 3.0
block
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 double
0 0 0 1 0 0 1 {height} 0 0 {height} 0
CELLS 1 5
4 0 1 2 3
CELL_TYPES 1
9
"""


def keys(folder: Path, text: str) -> tuple[str, str]:
    """Of the scene as a job, and as a row of a comparison."""
    (folder / "scene.toml").write_text(text)
    scene: Scene = load_scene(folder / "scene.toml")
    job: Any = Job("one", scene.data)
    return run_key(job, scene), row_key(scene, "one")


@pytest.mark.parametrize("load", LOADS.values(), ids=LOADS.keys())
def test_another_table_in_a_file_is_another_run(tmp_path: Path, load: str) -> None:
    text, table = SCENE.format(mesh=PLAIN, foot="bottom", load=load), tmp_path / "table.csv"
    table.write_text("0.0, 0.0\n1.0, 1.0\n")
    before = keys(tmp_path, text)
    assert keys(tmp_path, text) == before
    table.write_text("0.0, 0.0\n1.0, 2.0\n")
    after = keys(tmp_path, text)
    assert all(new != old for new, old in zip(after, before, strict=True))
    table.write_text("0.0, 0.0\n1.0, 1.0\n")
    assert keys(tmp_path, text) == before


def test_another_mesh_in_a_file_is_another_run(tmp_path: Path) -> None:
    text, mesh = SCENE.format(mesh=FROM_FILE, foot="boundary", load=""), tmp_path / "block.vtk"
    mesh.write_text(VTK.format(height=1))
    before = keys(tmp_path, text)
    mesh.write_text(VTK.format(height=2))
    after = keys(tmp_path, text)
    assert all(new != old for new, old in zip(after, before, strict=True))
