"""One scene on one machine is one run, to the last bit, whichever process computes it and what that did before.

Stops, kills and runs taken up again are in test_resume.py and test_kill.py, numbers of threads in
tests/unit/model/bodies/test_thread_blocks.py, kernels from compiler and cache in tests/unit/api/compiled.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import threadpoolctl

import contactlab
from contactlab.parts.machine import processor_name
from contactlab.run.simulation import simulate

MakeScene = Callable[..., Any]
Assert = Callable[[Any, Any], None]

FRICTION = {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}, "time.end": 3e-6}
STATICS = {"integrator": {"use": "newton", "steps": 10}, "time.end": 1.0, "supports.1.uy.to": -0.02}
# kernels of other algorithms, elements and laws are there before those of the run: what they share must not matter
BEFORE = {
    "contacts.0.algorithm": "node-on-segment", "bodies.disc.element": "q2", "contacts.0.friction": "none",
    "time.end": 2e-7,
}  # fmt: skip
PROGRAM = """
import sys
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene
from contactlab.scene.toml_text import parse_toml

for text, folder in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
    simulate(Scene.from_data(parse_toml(text, "scene.toml")), folder)
"""


def in_a_process(seed: str, *scenes: Any, folder: Path) -> Path:
    """Run the scenes one after the other in a process of their own; the folder of the last."""
    folders = [folder / str(number) for number in range(len(scenes))]
    words = [word for scene, out in zip(scenes, folders, strict=True) for word in (scene.toml(), str(out))]
    subprocess.run([sys.executable, "-c", PROGRAM, *words], env=os.environ | {"PYTHONHASHSEED": seed}, check=True)
    return folders[-1]


@pytest.mark.parametrize(
    "changes", [FRICTION, pytest.param(STATICS, marks=pytest.mark.full)], ids=["explicit, friction", "newton"]
)
@pytest.mark.parametrize("alone", [False, pytest.param(True, marks=pytest.mark.full)], ids=["later", "alone"])
def test_processes_compute_the_same_bits(
    changes: dict[str, Any], alone: bool, small_scene: MakeScene, tmp_path: Path, assert_same_run: Assert
) -> None:
    """Here, and in a process of its own, or in one that ran something else before and has more threads.

    Sets are in another order in each.
    """
    scene = small_scene({"contacts.0.algorithm": "mortar-p1", **changes})
    first = simulate(scene, tmp_path / "here")
    seed, scenes = ("1", [scene]) if alone else ("2", [scene.with_(BEFORE), scene.with_({"threads": 2})])
    other = in_a_process(seed, *scenes, folder=tmp_path / "other")
    assert_same_run(first, contactlab.load_results(other))
    for name in ("history.csv", "contact.csv"):
        assert (other / name).read_bytes() == (tmp_path / "here" / name).read_bytes(), name


@pytest.mark.full
def test_a_comparison_computes_the_same_bits_side_by_side(
    small_scene: MakeScene, tmp_path: Path, assert_same_run: Assert
) -> None:
    """One process that runs all, two that share them, and each run for itself."""
    scene = small_scene(FRICTION)
    vary = {"contacts.0.algorithm": ["mortar-p0", "mortar-p1"]}
    for name, jobs in (("serial", 1), ("parallel", 2)):
        contactlab.compare(scene, vary=vary, out=tmp_path / name, jobs=jobs)
    serial, parallel = (sorted((tmp_path / name / "runs").iterdir()) for name in ("serial", "parallel"))
    assert [one.name for one in serial] == [other.name for other in parallel]
    assert len(serial) == 2
    for one, other, algorithm in zip(serial, parallel, vary["contacts.0.algorithm"], strict=True):
        alone = simulate(scene.with_({"contacts.0.algorithm": algorithm}), tmp_path / algorithm)
        assert_same_run(alone, contactlab.load_results(one))
        assert_same_run(alone, contactlab.load_results(other))


def test_a_run_names_what_its_last_digits_depend_on(small_scene: MakeScene, tmp_path: Path) -> None:
    versions = simulate(small_scene({"time.end": 1e-7}), tmp_path / "run").summary["versions"]
    assert versions["processor"].startswith(processor_name())
    loaded = {library.get("architecture", "") for library in threadpoolctl.threadpool_info()}
    assert all(architecture in versions["BLAS"] for architecture in loaded)


def test_a_run_has_one_thread_of_blas_and_gives_the_others_back(small_scene: MakeScene) -> None:
    """Sums of BLAS that threads share depend on their number: a run in a comparison has one, and so have all."""
    seen: set[int] = set()

    def look(fraction: float, step: int, time: float, error: float) -> None:
        seen.update(library["num_threads"] for library in threadpoolctl.threadpool_info())

    with threadpoolctl.threadpool_limits(2, "blas"):
        before = [library["num_threads"] for library in threadpoolctl.threadpool_info()]
        simulate(small_scene({"time.end": 1e-7, "record.recorders": []}), progress=look)
        assert [library["num_threads"] for library in threadpoolctl.threadpool_info()] == before
    assert seen == {1}
