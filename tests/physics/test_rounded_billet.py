"""A billet with rounded corners between its tools: nodes and flanks come to bear one after another as it flattens."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

import contactlab
from contactlab.scene.scene import Scene

RADIUS, HALF, HEIGHT = 2.0, 8.0, 10.0  # mm
CORNER = 4  # columns of a corner, of equal angles


def write_billet(path: Path, columns: int = 28, rows: int = 10) -> None:
    """A rectangle 16 x 10 whose corners are quarters of circles of radius 2; groups of lines bottom and top."""
    round_ = HALF - RADIUS + RADIUS * np.sin(np.linspace(0.0, 0.5 * np.pi, CORNER + 1)[1:])
    x = np.concatenate([-round_[::-1], np.linspace(RADIUS - HALF, HALF - RADIUS, columns - 2 * CORNER + 1), round_])
    beyond = np.maximum(np.abs(x) - (HALF - RADIUS), 0.0)
    low = RADIUS - np.sqrt(np.maximum(RADIUS**2 - beyond**2, 0.0))
    y = low[:, None] + np.linspace(0.0, 1.0, rows + 1) * (HEIGHT - 2.0 * low)[:, None]
    points = np.column_stack([np.repeat(x, rows + 1), y.ravel(), np.zeros(y.size)])
    number = np.arange(y.size).reshape(y.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    bottom, top = np.stack([number[:-1, 0], number[1:, 0]], 1), np.stack([number[1:, -1], number[:-1, -1]], 1)
    tags = [np.full(len(bottom), 1), np.full(len(top), 2), np.full(len(quads), 3)]
    meshio.write(
        path,
        meshio.Mesh(
            points, [("line", bottom), ("line", top), ("quad", quads)],
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={"bottom": np.array([1, 1]), "top": np.array([2, 1]), "billet": np.array([3, 2])},
        ),
        file_format="gmsh22", binary=False,
    )  # fmt: skip


def forging(billet: Path) -> Scene:
    """The forging with this billet, softer than its tools, pressed by 0.48 mm in 12 wished load steps."""
    scene = contactlab.load_scene("three-body-forging")
    data = scene.data
    del data["symmetry"]
    data["integrator"] = {"use": "newton", "steps": 12}
    data["materials"]["soft"] = data["materials"]["aluminium"] | {"strength": 208.8}
    data["bodies"]["billet"] |= {"material": "soft", "mesh": {"use": "file", "path": str(billet)}}
    data["contacts"][0] |= {"master": "billet.bottom"}
    for contact in data["contacts"]:
        contact["algorithm"] = "mortar-p1"
    data["supports"][0]["uy"]["to"] = -0.48
    data["record"] = {"frames": 1, "recorders": []}
    return Scene.from_data(data)


def test_load_steps_get_past_multipliers_that_come_free(tmp_path: Path) -> None:
    """At 0.45 mm one does on either side: gaps and forces beside it jump, however short a step is."""
    write_billet(tmp_path / "billet.msh")
    results = contactlab.simulate(forging(tmp_path / "billet.msh"))
    assert results.status == "finished", results.reason
    cut = [event.text for event in results.events if "rejected after" in event.text]
    assert cut  # what the test is about has happened
    reactions = results.summary["reactions"]
    assert reactions["floor"][1] > 1000.0
    # steps end in equilibrium, tied or not
    assert abs(reactions["punch.top"][1] + reactions["floor"][1]) < 1e-6 * reactions["floor"][1]
