"""docs/troubleshooting.md: requests that are often wrong, and what the program answers.

    python tests/docs/wrong_requests.py

makes them all and writes the page; `test_troubleshooting.py` compares.
"""

from __future__ import annotations

import contextlib
import io
import os
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np

from contactlab.cli import main
from contactlab.scene.scene import bundled_scenes

PAGE = Path(__file__).parents[2] / "docs" / "troubleshooting.md"

HEAD = """# Troubleshooting

The program checks a request before it runs anything (exit status 2). Its message has the file and the key or the part,
the given value, the allowed values, and what to try. This page has thirty typical mistakes with their messages. It is
made by `python tests/docs/wrong_requests.py`, and a test compares it with the program.

For runs that start and then fail see [warnings](warnings.md). `contactlab doctor` lists what is missing on your
machine.
"""


class Wrong(NamedTuple):
    """A wrong request: a heading, the words typed, what is beside it in the folder, and what it is about."""

    title: str
    words: str
    prepare: Callable[[], None] = lambda: None
    note: str = ""


# --- own meshes -----------------------------------------------------------------------------------

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]])
TWO = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
TOP = np.array([[5, 4], [4, 3]])

SCENE = """\
[integrator]
use = "central-difference"

[materials.rubber]
use = "linear-elastic"
young = 10.0
poisson = 0.3
density = 1e-9

[bodies.pad]
element = "q1"
material = "rubber"
mesh = { use = "file", path = "pad.msh" }

[[supports]]
on = "pad.top"
uy = 0.0

[time]
end = 1e-3
"""


def write_scene(old: str = "", new: str = "") -> None:
    """own.toml, with one text in place of another."""
    assert old in SCENE
    Path("own.toml").write_text(SCENE.replace(old, new) if old else SCENE)


def write_mesh(points: np.ndarray = CORNERS, cells: np.ndarray = TWO, kind: str = "quad", name: str = "top") -> None:
    """pad.msh with a physical curve, and the scene that reads it."""
    blocks = [(kind, cells), ("line", TOP)]
    tags = [np.full(len(cells), 9), np.full(len(TOP), 1)]
    flat = np.column_stack([points, np.zeros(len(points))]) if points.shape[1] == 2 else points
    mesh = meshio.Mesh(
        flat, blocks, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={"pad": np.array([9, 2]), name: np.array([1, 1])},
    )  # fmt: skip
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        meshio.write("pad.msh", mesh, file_format="gmsh22")
    write_scene()


def _empty_file() -> None:
    write_scene()
    Path("pad.msh").touch()


def _triangles() -> None:
    write_mesh(cells=np.array([[0, 1, 4], [0, 4, 3]]), kind="triangle")


def _in_space() -> None:
    write_mesh(points=np.column_stack([CORNERS, [0.0, 0.0, 0.0, 0.5, 0.5, 0.5]]))


def _folded() -> None:
    points = CORNERS.copy()
    points[4] = (0.1, -0.2)
    write_mesh(points=points)


def _flat() -> None:
    points = CORNERS.copy()
    points[[3, 4], 1] = 0.0
    write_mesh(points=points)


def _in_pieces() -> None:
    points = np.concatenate([CORNERS, [[1.0, 0.0], [1.0, 1.0]]])  # the nodes between the two cells are there twice
    write_mesh(points=points, cells=np.array([[0, 1, 4, 3], [6, 2, 5, 7]]))


def _twice() -> None:
    write_mesh(cells=np.concatenate([TWO, TWO[:1]]))


def _other_group() -> None:
    write_mesh()
    write_scene('path = "pad.msh"', 'path = "pad.msh", cells = "pads"')


MESHES = [
    Wrong("The mesh file is elsewhere", "run own.toml", write_scene, "Paths are relative to the folder of the scene."),
    Wrong("The mesh file is empty, or of no known format", "run own.toml", _empty_file),
    Wrong("Triangles", "run own.toml", _triangles),
    Wrong("A mesh in space", "run own.toml", _in_space),
    Wrong("The side has another name in the file", "run own.toml", lambda: write_mesh(name="upper side"),
          "Names of Gmsh's physical curves are edge sets."),
    Wrong("The group of cells has another name", "run own.toml", _other_group),
    Wrong("A cell is folded", "run own.toml", _folded),
    Wrong("A cell has no area", "run own.toml", _flat),
    Wrong("Nodes are there twice, and the body falls apart", "run own.toml", _in_pieces),
    Wrong("Cells are there twice", "run own.toml", _twice),
]  # fmt: skip

# --- scenes, parts and commands ---------------------------------------------------------------------


def _scene_with(old: str, new: str) -> Callable[[], None]:
    def write() -> None:
        text = bundled_scenes()["disc-on-block"].read_text()
        assert old in text
        Path("mine.toml").write_text(text.replace(old, new, 1))

    return write


def _results_there() -> None:
    Path("results").mkdir()
    Path("results/summary.json").write_text("{}")


SCENES = [
    Wrong("A name that no scene has", "run disk-on-block"),
    Wrong("A command that does not exist", "rnu disc-on-block"),
    Wrong("A key that does not exist", "run mine.toml", _scene_with("symmetry =", "symetry =")),
    Wrong("A text without quotes", "run mine.toml", _scene_with('element = "q1"', "element = q1")),
    Wrong("A key that stands there twice", "run mine.toml",
          _scene_with('units = "mm N s t"', 'units = "mm N s t"\nunits = "m N s kg"')),
    Wrong("A number in quotes", "run mine.toml", _scene_with("young = 70000.0", 'young = "70000.0"')),
    Wrong("A number out of bounds", "run disc-on-block --set time.fraction=1.5"),
    Wrong("A material that cannot be", "run disc-on-block --set materials.soft.poisson=0.5"),
    Wrong("A field of a part is missing", "run disc-on-block --set contacts.0.friction=coulomb"),
    Wrong("A part of another kind", "run disc-on-block --set contacts.0.algorithm=coulomb"),
    Wrong("A part that is not installed", "run disc-on-block --set contacts.0.algorithm=mortar-p2"),
    Wrong("A body that does not exist", "run disc-on-block --set supports.0.on=blok.bottom"),
    Wrong("A side that does not exist", "run disc-on-block --set contacts.0.slave=disc.bottom"),
    Wrong("A material that no body is made of", "run disc-on-block --set bodies.block.material=steel"),
    Wrong("A step longer than the stable one", "run disc-on-block --set time.end=1e-5 --set time.step=1e-6"),
    Wrong("Bodies that overlap before the run", "run disc-on-block --set 'bodies.disc.shift=[0.0, -0.05]'"),
    Wrong("A body that nothing holds, in statics", "run disc-on-block --set integrator=newton --set supports=[]"),
    Wrong("Nothing is set", "run disc-on-block --set level:2"),
    Wrong("Results are there already", "run disc-on-block --out results", _results_there),
    Wrong("A file of parts that is not there", "run disc-on-block --with my_law.py"),
]  # fmt: skip

REQUESTS = [*SCENES, *MESHES]


def answer(wrong: Wrong) -> str:
    """What the program says, in an empty folder; paths are those of the folder."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        said = io.StringIO()
        try:
            wrong.prepare()
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
                status = main(shlex.split(wrong.words))
        finally:
            os.chdir(before)
        text = said.getvalue().replace(f"{Path(folder).resolve()}/", "").replace(f"{folder}/", "")
    if status != 2:
        raise AssertionError(f"{wrong.title}: exit status {status}\n{text}")
    return text.rstrip()


def lines_of(wrong: Wrong) -> Iterator[str]:
    """The part of the page about one request."""
    yield f"### {wrong.title}"
    if wrong.note:
        yield wrong.note
    yield f"```text\n$ contactlab {wrong.words}\n{answer(wrong)}\n```"


def page() -> str:
    """The whole page."""
    parts = [HEAD.rstrip(), "## Scenes, parts and commands"]
    parts += [line for wrong in SCENES for line in lines_of(wrong)]
    mesh = 'mesh = { use = "file", path = "pad.msh" }'
    parts += ["## Own meshes", f"The scene `own.toml` reads a mesh of its own: `{mesh}`."]
    parts += [line for wrong in MESHES for line in lines_of(wrong)]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    sys.exit(0)
