"""The how-tos from Gmsh files: geometry, mesh and scene belong together; numbers of the page are those of runs."""

from __future__ import annotations

import math
import re
from pathlib import Path

import meshio
import numpy as np
import pytest

from contactlab.results.results import Results
from contactlab.run.simulation import simulate
from contactlab.scene.scene import load_scene

FOLDER = Path(__file__).parents[2] / "docs" / "how-to"
NAMES = ["bearing", "cam", "ring", "snap-fit"]


def test_each_problem_has_its_files() -> None:
    for suffix in (".geo", ".msh", ".toml"):
        assert sorted(path.stem for path in FOLDER.glob(f"*{suffix}")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_scene_mesh_and_geometry_have_the_same_names(name: str) -> None:
    """Every set that a scene names is a physical group of the mesh, and those of the mesh are those of the geometry."""
    scene = (FOLDER / f"{name}.toml").read_text()
    groups = set(meshio.read(FOLDER / f"{name}.msh").field_data)
    assert groups == set(re.findall(r'Physical \w+\("(\w+)"\)', (FOLDER / f"{name}.geo").read_text()))
    used = set(re.findall(r'(?:slave|master|on) = "\w+\.(\w+)"', scene)) | set(re.findall(r'cells = "(\w+)"', scene))
    assert used
    assert used <= groups
    assert load_scene(str(FOLDER / f"{name}.toml"))


def run(name: str, folder: Path) -> Results:
    results = simulate(load_scene(str(FOLDER / f"{name}.toml")), folder)
    assert results.status == "finished"
    section = re.split(r"\n## ", (FOLDER / "README.md").read_text())[
        1 + ["snap-fit", "bearing", "cam", "ring"].index(name)
    ]
    assert f"{name}.toml" in section
    assert {warning.code for warning in results.warnings} == set(re.findall(r"warns\s+`([a-z-]+)`", section))
    return results


@pytest.mark.full
def test_a_hook_that_drags_has_the_coefficient_of_friction(tmp_path: Path) -> None:
    """On a flat top all force is along one normal: the ratio of reactions is mu, to a hundredth of it."""
    history = run("snap-fit", tmp_path / "run").history
    assert history["clip.root.fx"][-1] / -history["clip.root.fy"][-1] == pytest.approx(0.2, rel=0.01)
    assert history["clip.root.fx"].max() > 3.0 * history["clip.root.fx"][-1]  # it went over a peak


@pytest.mark.full
def test_pressures_of_the_roller_are_those_of_hertz(tmp_path: Path) -> None:
    """5 %: cells are a third of the half-width, and the races are sectors, not half-spaces."""
    results = run("bearing", tmp_path / "run")
    force = results.history["inner.shaft.fy"][-1]
    modulus = 210000.0 / (1.0 - 0.3**2) / 2.0
    curvatures = (1.0 / 3.0 - 1.0 / 20.0, 1.0 / 3.0 + 1.0 / 14.0)
    for number, curvature in enumerate(curvatures):
        peak = results.summary["peaks"]["contacts"][f"contacts.{number}"]["pressure"]["value"]
        assert peak == pytest.approx(math.sqrt(force * modulus * curvature / math.pi), rel=0.05)


@pytest.mark.full
def test_the_cam_carries_the_force_of_the_spring(tmp_path: Path) -> None:
    """Equilibrium along y, to the tolerance of the solver; the plastic gives way by less than 15 % of the rise.

    The spring is spread evenly over the length of the head, at the top of all: its force is that of the mean along it.
    """
    results = run("cam", tmp_path / "run")
    nodes, moved = results.layout.nodes, results.frames[-1].displacement
    head = np.flatnonzero(nodes[:, 1] == nodes[:, 1].max())
    head = head[np.argsort(nodes[head, 0])]
    x, along = nodes[head, 0], moved[head, 1]
    lift = float((0.5 * (along[1:] + along[:-1]) * np.diff(x)).sum() / (x[-1] - x[0]))
    assert results.history["cam.bore.fy"][-1] == pytest.approx(100.0 * lift, rel=1e-4)
    assert 0.85 * 2.0 * math.sin(math.pi / 3.0) < lift < 2.0 * math.sin(math.pi / 3.0)


@pytest.mark.full
def test_the_crushed_ring_touches_itself(tmp_path: Path) -> None:
    """It bends softly until its halves meet at twice its inner radius; pressed together they are stiffer by far."""
    results = run("ring", tmp_path / "run")
    history = results.history
    apart = -history["ring.head.uy"] < 16.6
    assert -history["ring.head.fy"][-1] > 20.0 * abs(history["ring.head.fy"][apart]).max()
